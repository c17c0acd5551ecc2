(function() {
	// \0rolldown/runtime.js
	var __create = Object.create;
	var __defProp = Object.defineProperty;
	var __getOwnPropDesc = Object.getOwnPropertyDescriptor;
	var __getOwnPropNames = Object.getOwnPropertyNames;
	var __getProtoOf = Object.getPrototypeOf;
	var __hasOwnProp = Object.prototype.hasOwnProperty;
	var __commonJSMin = (cb, mod) => () => (mod || (cb((mod = { exports: {} }).exports, mod, mod.exports), cb = null), mod.exports);
	var __copyProps = (to, from, except, desc) => {
		if (from && typeof from === "object" || typeof from === "function") for (var keys = __getOwnPropNames(from), i = 0, n = keys.length, key; i < n; i++) {
			key = keys[i];
			if (!__hasOwnProp.call(to, key) && key !== except) __defProp(to, key, {
				get: ((k) => from[k]).bind(null, key),
				enumerable: !(desc = __getOwnPropDesc(from, key)) || desc.enumerable
			});
		}
		return to;
	};
	var __toESM = (mod, isNodeMode, target) => (target = mod != null ? __create(__getProtoOf(mod)) : {}, __copyProps(isNodeMode || !mod || !mod.__esModule || !__hasOwnProp.call(mod, "default") ? __defProp(target, "default", {
		value: mod,
		enumerable: true
	}) : target, mod));
	// src/graph/picture.ts
	var import_elk_api = /* @__PURE__ */ __toESM((/* @__PURE__ */ __commonJSMin(((exports, module) => {
		(function(f) {
			if (typeof exports === "object" && typeof module !== "undefined") module.exports = f();
			else if (typeof define === "function" && define.amd) define([], f);
			else {
				var g;
				if (typeof window !== "undefined") g = window;
				else if (typeof global !== "undefined") g = global;
				else if (typeof self !== "undefined") g = self;
				else g = this;
				g.ELK = f();
			}
		})(function() {
			return (function() {
				function r(e, n, t) {
					function o(i, f) {
						if (!n[i]) {
							if (!e[i]) {
								var c = "function" == typeof require && require;
								if (!f && c) return c(i, !0);
								if (u) return u(i, !0);
								var a = /* @__PURE__ */ new Error("Cannot find module '" + i + "'");
								throw a.code = "MODULE_NOT_FOUND", a;
							}
							var p = n[i] = { exports: {} };
							e[i][0].call(p.exports, function(r) {
								var n = e[i][1][r];
								return o(n || r);
							}, p, p.exports, r, e, n, t);
						}
						return n[i].exports;
					}
					for (var u = "function" == typeof require && require, i = 0; i < t.length; i++) o(t[i]);
					return o;
				}
				return r;
			})()({
				1: [function(require, module, exports) {
					"use strict";
					Object.defineProperty(exports, "__esModule", { value: true });
					exports["default"] = void 0;
					function _typeof(o) {
						"@babel/helpers - typeof";
						return _typeof = "function" == typeof Symbol && "symbol" == typeof Symbol.iterator ? function(o) {
							return typeof o;
						} : function(o) {
							return o && "function" == typeof Symbol && o.constructor === Symbol && o !== Symbol.prototype ? "symbol" : typeof o;
						}, _typeof(o);
					}
					function _classCallCheck(a, n) {
						if (!(a instanceof n)) throw new TypeError("Cannot call a class as a function");
					}
					function _defineProperties(e, r) {
						for (var t = 0; t < r.length; t++) {
							var o = r[t];
							o.enumerable = o.enumerable || !1, o.configurable = !0, "value" in o && (o.writable = !0), Object.defineProperty(e, _toPropertyKey(o.key), o);
						}
					}
					function _createClass(e, r, t) {
						return r && _defineProperties(e.prototype, r), t && _defineProperties(e, t), Object.defineProperty(e, "prototype", { writable: !1 }), e;
					}
					function _toPropertyKey(t) {
						var i = _toPrimitive(t, "string");
						return "symbol" == _typeof(i) ? i : i + "";
					}
					function _toPrimitive(t, r) {
						if ("object" != _typeof(t) || !t) return t;
						var e = t[Symbol.toPrimitive];
						if (void 0 !== e) {
							var i = e.call(t, r || "default");
							if ("object" != _typeof(i)) return i;
							throw new TypeError("@@toPrimitive must return a primitive value.");
						}
						return ("string" === r ? String : Number)(t);
					}
					exports["default"] = /*#__PURE__*/ function() {
						function ELK() {
							var _this = this;
							var _ref = arguments.length > 0 && arguments[0] !== void 0 ? arguments[0] : {}, _ref$defaultLayoutOpt = _ref.defaultLayoutOptions, defaultLayoutOptions = _ref$defaultLayoutOpt === void 0 ? {} : _ref$defaultLayoutOpt, _ref$algorithms = _ref.algorithms, algorithms = _ref$algorithms === void 0 ? [
								"layered",
								"stress",
								"mrtree",
								"radial",
								"force",
								"disco",
								"sporeOverlap",
								"sporeCompaction",
								"rectpacking"
							] : _ref$algorithms, workerFactory = _ref.workerFactory, workerUrl = _ref.workerUrl;
							_classCallCheck(this, ELK);
							this.defaultLayoutOptions = defaultLayoutOptions;
							this.initialized = false;
							if (typeof workerUrl === "undefined" && typeof workerFactory === "undefined") throw new Error("Cannot construct an ELK without both 'workerUrl' and 'workerFactory'.");
							var factory = workerFactory;
							if (typeof workerUrl !== "undefined" && typeof workerFactory === "undefined") factory = function factory(url) {
								return new Worker(url);
							};
							var worker = factory(workerUrl);
							if (typeof worker.postMessage !== "function") throw new TypeError("Created worker does not provide the required 'postMessage' function.");
							this.worker = new PromisedWorker(worker);
							this.worker.postMessage({
								cmd: "register",
								algorithms
							}).then(function(r) {
								return _this.initialized = true;
							})["catch"](console.err);
						}
						return _createClass(ELK, [
							{
								key: "layout",
								value: function layout(graph) {
									var _ref2 = arguments.length > 1 && arguments[1] !== void 0 ? arguments[1] : {}, _ref2$layoutOptions = _ref2.layoutOptions, layoutOptions = _ref2$layoutOptions === void 0 ? this.defaultLayoutOptions : _ref2$layoutOptions, _ref2$logging = _ref2.logging, logging = _ref2$logging === void 0 ? false : _ref2$logging, _ref2$measureExecutio = _ref2.measureExecutionTime, measureExecutionTime = _ref2$measureExecutio === void 0 ? false : _ref2$measureExecutio;
									if (!graph) return Promise.reject(/* @__PURE__ */ new Error("Missing mandatory parameter 'graph'."));
									return this.worker.postMessage({
										cmd: "layout",
										graph,
										layoutOptions,
										options: {
											logging,
											measureExecutionTime
										}
									});
								}
							},
							{
								key: "knownLayoutAlgorithms",
								value: function knownLayoutAlgorithms() {
									return this.worker.postMessage({ cmd: "algorithms" });
								}
							},
							{
								key: "knownLayoutOptions",
								value: function knownLayoutOptions() {
									return this.worker.postMessage({ cmd: "options" });
								}
							},
							{
								key: "knownLayoutCategories",
								value: function knownLayoutCategories() {
									return this.worker.postMessage({ cmd: "categories" });
								}
							},
							{
								key: "terminateWorker",
								value: function terminateWorker() {
									if (this.worker) this.worker.terminate();
								}
							}
						]);
					}();
					var PromisedWorker = /*#__PURE__*/ function() {
						function PromisedWorker(worker) {
							var _this2 = this;
							_classCallCheck(this, PromisedWorker);
							if (worker === void 0) throw new Error("Missing mandatory parameter 'worker'.");
							this.resolvers = {};
							this.worker = worker;
							this.worker.onmessage = function(answer) {
								setTimeout(function() {
									_this2.receive(_this2, answer);
								}, 0);
							};
						}
						return _createClass(PromisedWorker, [
							{
								key: "postMessage",
								value: function postMessage(msg) {
									var id = this.id || 0;
									this.id = id + 1;
									msg.id = id;
									var self = this;
									return new Promise(function(resolve, reject) {
										self.resolvers[id] = function(err, res) {
											if (err) {
												self.convertGwtStyleError(err);
												reject(err);
											} else resolve(res);
										};
										self.worker.postMessage(msg);
									});
								}
							},
							{
								key: "receive",
								value: function receive(self, answer) {
									var json = answer.data;
									var resolver = self.resolvers[json.id];
									if (resolver) {
										delete self.resolvers[json.id];
										if (json.error) resolver(json.error);
										else resolver(null, json.data);
									}
								}
							},
							{
								key: "terminate",
								value: function terminate() {
									if (this.worker) this.worker.terminate();
								}
							},
							{
								key: "convertGwtStyleError",
								value: function convertGwtStyleError(err) {
									if (!err) return;
									var javaException = err["__java$exception"];
									if (javaException) {
										if (javaException.cause && javaException.cause.backingJsObject) {
											err.cause = javaException.cause.backingJsObject;
											this.convertGwtStyleError(err.cause);
										}
										delete err["__java$exception"];
									}
								}
							}
						]);
					}();
				}, {}],
				2: [function(require, module, exports) {
					"use strict";
					/*******************************************************************************
					* Copyright (c) 2021 Kiel University and others.
					* 
					* This program and the accompanying materials are made available under the
					* terms of the Eclipse Public License 2.0 which is available at
					* https://www.eclipse.org/legal/epl-2.0.
					* 
					* This Source Code may also be made available under the following Secondary
					* Licenses when the conditions for such availability set forth in the Eclipse
					* Public License v. 2.0 are satisfied: GPL-3.0 which is available at
					* https://www.gnu.org/licenses/gpl-3.0-standalone.html.
					*
					* SPDX-License-Identifier: EPL-2.0 OR GPL-3.0-or-later
					*******************************************************************************/
					var ELK = require("./elk-api.js")["default"];
					Object.defineProperty(module.exports, "__esModule", { value: true });
					module.exports = ELK;
					ELK["default"] = ELK;
				}, { "./elk-api.js": 1 }]
			}, {}, [2])(2);
		});
	})))(), 1);
	var isJunction = (node) => node.kind === "0" || node.kind === "1";
	var isStorage = (kind) => kind === "I" || kind === "C";
	var isEnergetic = (kind) => isStorage(kind) || kind === "R" || kind === "MR";
	var isSource = (kind) => kind === "Se" || kind === "Sf" || kind === "MSe" || kind === "MSf";
	var isTwoPort = (kind) => kind === "TF" || kind === "GY" || kind === "MTF" || kind === "MGY";
	var isInformation = (kind) => kind === "controller" || kind === "signal" || kind === "input";
	// src/graph/text.ts
	/**
	* Widths of text without a browser, so that a page, a notebook and a static file place everything alike.
	*
	* Widths are those of Helvetica and of the fonts that share its metrics (Arial, Liberation Sans), in thousandths of the
	* size, from Adobe's font metrics. Every text is drawn with its length, so another font is fitted to the place.
	*/
	var FONT = "Helvetica, Arial, 'Liberation Sans', sans-serif";
	var REGULAR = {
		" ": 278,
		"!": 278,
		"\"": 355,
		"#": 556,
		$: 556,
		"%": 889,
		"&": 667,
		"'": 191,
		"(": 333,
		")": 333,
		"*": 389,
		"+": 584,
		",": 278,
		"-": 333,
		".": 278,
		"/": 278,
		":": 278,
		";": 278,
		"<": 584,
		"=": 584,
		">": 584,
		"?": 556,
		"@": 1015,
		A: 667,
		B: 667,
		C: 722,
		D: 722,
		E: 667,
		F: 611,
		G: 778,
		H: 722,
		I: 278,
		J: 500,
		K: 667,
		L: 556,
		M: 833,
		N: 722,
		O: 778,
		P: 667,
		Q: 778,
		R: 722,
		S: 667,
		T: 611,
		U: 722,
		V: 667,
		W: 944,
		X: 667,
		Y: 667,
		Z: 611,
		"[": 278,
		"]": 278,
		_: 556,
		a: 556,
		b: 556,
		c: 500,
		d: 556,
		e: 556,
		f: 278,
		g: 556,
		h: 556,
		i: 222,
		j: 222,
		k: 500,
		l: 222,
		m: 833,
		n: 556,
		o: 556,
		p: 556,
		q: 556,
		r: 333,
		s: 500,
		t: 278,
		u: 556,
		v: 500,
		w: 722,
		x: 500,
		y: 500,
		z: 500,
		"…": 1e3
	};
	var OTHER = 600;
	var BOLD = 1.06;
	/** The width of a text in px. */
	function widthOf(text, size, bold = false) {
		let sum = 0;
		for (const letter of text) sum += REGULAR[letter] ?? (letter >= "0" && letter <= "9" ? 556 : OTHER);
		return sum * size * (bold ? BOLD : 1) / 1e3;
	}
	/** The text, shortened in the middle where it is longer than some letters. */
	function shortened(text, most) {
		if (text.length <= most) return text;
		const head = Math.ceil((most - 1) / 2);
		return `${text.slice(0, head)}…${text.slice(text.length - (most - 1 - head))}`;
	}
	var BOX = 26;
	var GAP = 14;
	var ARM = 40;
	var MOST_A_SIDE = 4;
	var MOST_LETTERS = 20;
	/** What is written in an element: `I : name`, and for two-ports and junctions the symbol alone. */
	function labelOf(node) {
		if (isJunction(node) || isTwoPort(node.kind)) return node.kind;
		const name = shortened(node.name, MOST_LETTERS);
		return isInformation(node.kind) ? name : `${node.kind} : ${name}`;
	}
	/** Group what is visible into figures. */
	function figuresOf(visible) {
		const nodes = new Map(visible.nodes.map((node) => [node.path, node]));
		const at = /* @__PURE__ */ new Map();
		for (const bond of visible.bonds) for (const end of [bond.tail, bond.head]) {
			const list = at.get(end) ?? [];
			list.push(bond);
			at.set(end, list);
		}
		const taken = /* @__PURE__ */ new Set();
		const figures = [];
		for (const junction of visible.nodes.filter(isJunction)) {
			const above = [];
			const below = [];
			for (const bond of at.get(junction.path) ?? []) {
				const other = nodes.get(bond.tail === junction.path ? bond.head : bond.tail);
				if (other === void 0 || other.group !== junction.group) continue;
				if (isJunction(other) || isTwoPort(other.kind) || (at.get(other.path) ?? []).length !== 1) continue;
				const [first, second] = other.kind === "I" || isSource(other.kind) ? [above, below] : [below, above];
				const side = first.length < MOST_A_SIDE ? first : second.length < MOST_A_SIDE ? second : void 0;
				if (side === void 0) continue;
				side.push([other, bond]);
				taken.add(other.path);
			}
			const outer = (at.get(junction.path) ?? []).length - above.length - below.length;
			figures.push(junctionFigure(junction, above, below, outer));
		}
		for (const node of visible.nodes) {
			if (isJunction(node) || taken.has(node.path)) continue;
			figures.push(singleFigure(node, (at.get(node.path) ?? []).length));
		}
		for (const closed of visible.closed) figures.push(closedFigure(closed, (at.get(`group:${closed.path}`) ?? []).length));
		return figures;
	}
	function elementSpot(node, x, y) {
		const label = labelOf(node);
		const note = isTwoPort(node.kind) ? shortened(node.name, MOST_LETTERS) : "";
		const plain = isJunction(node) || isTwoPort(node.kind);
		const width = Math.ceil(plain ? Math.max(22, widthOf(label, 13) + 12) : widthOf(label, 12) + 20);
		return {
			id: node.path,
			node,
			closed: void 0,
			label,
			note,
			x,
			y,
			width,
			height: plain ? 20 : BOX
		};
	}
	function junctionFigure(junction, above, below, outer) {
		const corridor = Math.max(16, 8 * Math.ceil(outer / 2) + 8);
		const widest = (side) => side.reduce((sum, [node]) => sum + elementSpot(node, 0, 0).width + GAP, -14);
		const width = Math.max(56, widest(above), widest(below));
		const arm = Math.max(ARM, corridor + 22);
		const top = above.length > 0 ? BOX + arm : corridor;
		const bottom = below.length > 0 ? BOX + arm : corridor;
		const middle = top;
		const spots = [elementSpot(junction, width / 2, middle)];
		for (const [side, y] of [[above, middle - arm - BOX / 2], [below, middle + arm + BOX / 2]]) {
			let x = (width - widest(side)) / 2;
			for (const [node] of side) {
				const spot = elementSpot(node, 0, y);
				spots.push({
					...spot,
					x: x + spot.width / 2
				});
				x += spot.width + GAP;
			}
		}
		return {
			id: junction.path,
			group: junction.group,
			width,
			height: top + bottom,
			spots,
			inner: [...above, ...below].map(([, bond]) => bond),
			middle
		};
	}
	function singleFigure(node, bonds) {
		const spot = elementSpot(node, 0, 0);
		const note = spot.note === "" ? 0 : 26;
		const height = Math.max(spot.height + note, 16 * Math.ceil(bonds / 2) + 6);
		const width = Math.max(spot.width, Math.ceil(widthOf(spot.note, 10)) + 4);
		const boxed = isTwoPort(node.kind) ? spot.height : Math.max(spot.height, 16 * Math.ceil(bonds / 2) + 6);
		return {
			id: node.path,
			group: node.group,
			width,
			height,
			spots: [{
				...spot,
				x: width / 2,
				y: height / 2,
				height: boxed
			}],
			inner: [],
			middle: height / 2
		};
	}
	/** What a closed group tells of what is in it. */
	function noteOf(closed) {
		if (closed.rows === 0) return "";
		if (closed.kept < closed.rows) return `${closed.kept} of ${closed.rows} kept`;
		return `${closed.rows} ${closed.rows === 1 ? "element" : "elements"}`;
	}
	function closedFigure(closed, bonds) {
		const label = shortened(closed.name, 28);
		const note = noteOf(closed);
		const width = Math.ceil(Math.max(90, widthOf(label, 13, true) + 44, widthOf(note, 10) + 24));
		const height = Math.max(48, 16 * (bonds + 1));
		const id = `group:${closed.path}`;
		return {
			id,
			group: closed.group,
			width,
			height,
			spots: [{
				id,
				node: void 0,
				closed,
				label,
				note,
				x: width / 2,
				y: height / 2,
				width,
				height
			}],
			inner: [],
			middle: height / 2
		};
	}
	// src/graph/notation.ts
	var COLOURS = {
		light: {
			paper: "#ffffff",
			ink: "#16191d",
			quiet: "#5f6873",
			frame: "#eef2f7",
			frameLine: "#a9b7c8",
			closed: "#e2e9f2",
			element: "#ffffff",
			signal: "#6b4a8e",
			stroke: {
				preferred: "#000000",
				dependent: "#d96a00",
				conflict: "#d00000",
				fixed: "#000000"
			}
		},
		dark: {
			paper: "#14171b",
			ink: "#eef1f4",
			quiet: "#9aa5b1",
			frame: "#1b2027",
			frameLine: "#4a5767",
			closed: "#252d38",
			element: "#14171b",
			signal: "#c3a5e6",
			stroke: {
				preferred: "#ffffff",
				dependent: "#ffa14a",
				conflict: "#ff6b6b",
				fixed: "#ffffff"
			}
		}
	};
	var DOMAINS = {
		translation: {
			light: "#007f00",
			dark: "#4cc24c"
		},
		rotation: {
			light: "#5f5f5f",
			dark: "#b0b0b0"
		},
		hydraulic: {
			light: "#007fff",
			dark: "#4da6ff"
		},
		thermal: {
			light: "#bf0000",
			dark: "#ff6b5e"
		},
		electrical: {
			light: "#0000ff",
			dark: "#8f9bff"
		},
		magnetic: {
			light: "#ff7f00",
			dark: "#ffa64d"
		}
	};
	var OTHER_DOMAIN = {
		light: "#8a5a00",
		dark: "#d9b45b"
	};
	/** The colour of a domain; pseudo domains have that of the true one, others share one colour. */
	function domainColour(domain, theme) {
		return (DOMAINS[domain] ?? DOMAINS[domain.replace(/^pseudo_/, "")] ?? OTHER_DOMAIN)[theme];
	}
	/** The scale of activity: shares of the total below the first count as nothing. */
	var LEAST = 1e-5;
	var SCALE = [
		"#fff8e1",
		"#fee29a",
		"#fdc25a",
		"#f99a3c",
		"#ec6a2c",
		"#cf3a27",
		"#9c1220"
	];
	/** Where a share stands on the logarithmic scale, from 0 to 1. */
	var level = (share) => share <= 1e-5 ? 0 : Math.min(1, 1 - Math.log(share) / Math.log(LEAST));
	/** The fill of an element with a share of the activity. */
	function activityColour(share) {
		const place = level(share) * (SCALE.length - 1);
		const low = Math.min(Math.floor(place), SCALE.length - 2);
		return mixed(SCALE[low], SCALE[low + 1], place - low);
	}
	/** The colour of letters on a fill: dark or white, whichever stands out. */
	function lettersOn(fill) {
		const [r, g, b] = channels(fill).map((c) => c / 255 <= .03928 ? c / 255 / 12.92 : ((c / 255 + .055) / 1.055) ** 2.4);
		return .2126 * r + .7152 * g + .0722 * b > .179 ? "#000000" : "#ffffff";
	}
	function channels(colour) {
		const value = parseInt(colour.slice(1), 16);
		return [
			value >> 16 & 255,
			value >> 8 & 255,
			value & 255
		];
	}
	function mixed(a, b, share) {
		const [from, to] = [channels(a), channels(b)];
		return `#${from.map((c, i) => Math.round(c + (to[i] - c) * share)).map((c) => c.toString(16).padStart(2, "0")).join("")}`;
	}
	/** The width of a bond with a share of the greatest activity of bonds. */
	var bondWidth = (share) => 1.3 + 4.2 * Math.sqrt(Math.min(1, Math.max(0, share)));
	var BARB = 10;
	var STROKE = 12;
	/** The barb of a half arrow at the end of a line: on its lower side, or on the right of an upright line. */
	function barb(before, tip) {
		const length = Math.hypot(tip.x - before.x, tip.y - before.y) || 1;
		const [ux, uy] = [(tip.x - before.x) / length, (tip.y - before.y) / length];
		let [nx, ny] = [-uy, ux];
		if (Math.abs(ny) > .35 ? ny < 0 : nx < 0) [nx, ny] = [-nx, -ny];
		return {
			x: tip.x - BARB * ux + .55 * BARB * nx,
			y: tip.y - BARB * uy + .55 * BARB * ny
		};
	}
	/** The two ends of a causal stroke across the end of a line. */
	function stroke(before, end, width) {
		const length = Math.hypot(end.x - before.x, end.y - before.y) || 1;
		const [nx, ny] = [-(end.y - before.y) / length, (end.x - before.x) / length];
		const half = STROKE / 2 + Math.max(0, width - 2) / 2;
		return [{
			x: end.x + half * nx,
			y: end.y + half * ny
		}, {
			x: end.x - half * nx,
			y: end.y - half * ny
		}];
	}
	// src/graph/xml.ts
	/** Writing XML. */
	/** A number as short as a hundredth of a px needs. */
	var number = (value) => String(Math.round(value * 100) / 100);
	/** Text that is safe between tags and in attributes. */
	var escaped = (text) => text.replace(/&/g, "&amp;").replace(/</g, "&lt;").replace(/>/g, "&gt;").replace(/"/g, "&quot;");
	/** An element with attributes; `content` is XML already. */
	function tag(name, attributes, content = "") {
		const written = Object.entries(attributes).map(([key, value]) => ` ${key}="${typeof value === "number" ? number(value) : escaped(value)}"`).join("");
		return content === "" ? `<${name}${written}/>` : `<${name}${written}>${content}</${name}>`;
	}
	// src/graph/legend.ts
	/** The legend: which domain has which colour, what strokes mean, and the scale of activity. */
	var STEPS = 20;
	/** The legend of a picture, below it. */
	function legend(picture, top, theme) {
		const colours = COLOURS[theme];
		const parts = [];
		const write = (text, x, y) => {
			const width = widthOf(text, 10);
			parts.push(tag("text", {
				x,
				y,
				fill: colours.ink,
				"font-size": 10,
				textLength: width,
				lengthAdjust: "spacingAndGlyphs"
			}, escaped(text)));
			return x + width;
		};
		const line = (x, y, colour, width, dash = "") => {
			const look = dash === "" ? {} : { "stroke-dasharray": dash };
			parts.push(tag("path", {
				d: `M${number(x)} ${number(y)}h22`,
				stroke: colour,
				"stroke-width": width,
				...look
			}));
		};
		let x = 12;
		let y = top + 20;
		for (const domain of [...new Set(picture.bonds.map((bond) => bond.domain))].sort()) {
			line(x, y - 3, domainColour(domain, theme), 2.2);
			x = write(domain.replace("_", " "), x + 26, y) + 16;
		}
		if (picture.signals.length > 0) {
			line(x, y - 3, colours.signal, .9);
			x = write("signal", x + 26, y) + 16;
		}
		x = 12;
		y += 20;
		const strokes = new Set(picture.bonds.map((bond) => bond.causality));
		for (const [kind, words] of [
			["preferred", "causal stroke: effort goes in here"],
			["dependent", "dependent storage"],
			["conflict", "conflict"]
		]) {
			if (!strokes.has(kind)) continue;
			parts.push(tag("path", {
				d: `M${number(x + 4)} ${number(y - 9)}v12`,
				stroke: colours.stroke[kind],
				"stroke-width": 2.4
			}));
			x = write(words, x + 12, y) + 16;
		}
		if (picture.nodes.some((node) => node.gone !== void 0)) {
			line(x, y - 3, colours.quiet, 1.2, "4 3");
			x = write("gone, with what stands in its place", x + 26, y) + 16;
		}
		if (picture.activity !== void 0) {
			x = write("activity", x, y) + 6;
			x = write(LEAST.toExponential(0), x, y) + 4;
			for (let i = 0; i < STEPS; i++) {
				const fill = activityColour(LEAST ** (1 - (i + .5) / STEPS));
				parts.push(tag("rect", {
					x: x + 5 * i,
					y: y - 9,
					width: 5.2,
					height: 11,
					fill
				}));
			}
			x = write("1 of the total", x + 100 + 4, y);
		}
		return tag("g", { class: "legend" }, parts.join(""));
	}
	// src/graph/draw.ts
	/** Draw a layout. */
	function draw(picture, layout, options) {
		const { attributes, parts } = drawnParts(picture, layout, options);
		return tag("svg", attributes, parts.join("\n"));
	}
	function drawnParts(picture, layout, options) {
		const colours = COLOURS[options.theme];
		const pen = new Pen(picture, colours, options.theme, options.below ?? /* @__PURE__ */ new Set());
		const width = Math.max(layout.width, options.legend ? 620 : 0);
		const height = layout.height + (options.legend ? 58 : 0);
		const parts = [
			tag("title", {}, escaped(`Bond graph of ${picture.name}`)),
			tag("rect", {
				width,
				height,
				fill: colours.paper
			}),
			...layout.frames.map((frame) => pen.frame(frame)),
			...layout.signals.map((line) => pen.signal(line)),
			...layout.spots.map((spot) => pen.spot(spot)),
			...layout.bonds.map((line) => pen.bond(line)),
			options.legend ? legend(picture, layout.height, options.theme) : ""
		];
		return {
			attributes: {
				xmlns: "http://www.w3.org/2000/svg",
				class: "bond-graph",
				viewBox: `0 0 ${number(width)} ${number(height)}`,
				width,
				height,
				"font-family": FONT,
				"font-size": 12,
				role: "img"
			},
			parts: parts.filter((part) => part !== "")
		};
	}
	var Pen = class {
		colours;
		theme;
		below;
		activity;
		greatest;
		constructor(picture, colours, theme, below) {
			this.colours = colours;
			this.theme = theme;
			this.below = below;
			this.activity = picture.activity;
			this.greatest = Math.max(1e-300, ...Object.values(picture.activity?.bonds ?? {}));
		}
		frame(frame) {
			const { x, y, width, height } = frame;
			return tag("g", {
				class: "group",
				"data-group": frame.path
			}, tag("title", {}, escaped(frame.path)) + tag("rect", {
				x,
				y,
				width,
				height,
				rx: 8,
				fill: this.colours.frame,
				stroke: this.colours.frameLine
			}) + this.letters(`▾ ${frame.name}`, x + 10, y + 20, {
				size: 13,
				bold: true,
				anchor: "start",
				fill: this.colours.quiet
			}));
		}
		bond(line) {
			const { bond } = line.shown;
			const share = this.activity === void 0 ? void 0 : (this.activity.bonds[bond.name] ?? 0) / this.greatest;
			const width = bond.gone === true ? 1.2 : share === void 0 ? 1.6 : bondWidth(share);
			const isConflict = bond.causality === "conflict";
			const colour = bond.gone === true ? this.colours.quiet : isConflict ? this.colours.stroke.conflict : domainColour(bond.domain, this.theme);
			const points = line.points;
			const last = points.length - 1;
			const tip = points[last];
			const side = barb(points[last - 1], tip);
			const pen = {
				fill: "none",
				stroke: colour,
				"stroke-width": width
			};
			const dash = bond.gone === true ? { "stroke-dasharray": "4 3" } : {};
			const parts = [
				tag("title", {}, escaped(`${bond.name} (${bond.domain})`)),
				tag("path", {
					class: "line",
					d: path(points),
					"stroke-linejoin": "round",
					...pen,
					...dash
				}),
				tag("path", {
					class: "barb",
					d: path([tip, side]),
					"stroke-linecap": "round",
					...pen
				})
			];
			if (bond.effortInto !== void 0 && bond.causality !== "none") {
				const atHead = bond.effortInto === bond.head;
				const [end, before] = atHead ? [tip, points[last - 1]] : [points[0], points[1]];
				const ends = stroke(before, end, width);
				const ink = bond.gone === true ? this.colours.quiet : this.colours.stroke[bond.causality];
				parts.push(tag("path", {
					class: `stroke ${bond.causality}`,
					"data-end": atHead ? "head" : "tail",
					d: path(ends),
					stroke: ink,
					"stroke-width": 2.4
				}));
				if (bond.causality === "fixed") parts.push(tag("circle", {
					cx: ends[0].x,
					cy: ends[0].y,
					r: 2.6,
					fill: ink
				}));
			}
			if (isConflict) parts.push(this.cross(halfway(points)));
			return tag("g", {
				class: bond.gone === true ? "bond gone" : "bond",
				"data-bond": bond.name
			}, parts.join(""));
		}
		signal(line) {
			const [start, first, second, tip] = line.points;
			const length = Math.hypot(tip.x - second.x, tip.y - second.y) || 1;
			const [ux, uy] = [(tip.x - second.x) / length, (tip.y - second.y) / length];
			const head = [
				tip,
				{
					x: tip.x - 8 * ux - 3 * uy,
					y: tip.y - 8 * uy + 3 * ux
				},
				{
					x: tip.x - 8 * ux + 3 * uy,
					y: tip.y - 8 * uy - 3 * ux
				}
			];
			const pairs = [
				first,
				second,
				tip
			].map((point) => `${number(point.x)} ${number(point.y)}`).join(",");
			const d = `M${number(start.x)} ${number(start.y)}C${pairs}`;
			return tag("g", {
				class: "signal",
				"data-from": line.signal.from,
				"data-to": line.signal.to
			}, tag("path", {
				d,
				fill: "none",
				stroke: this.colours.signal,
				"stroke-width": .8,
				"stroke-opacity": .75
			}) + tag("path", {
				d: `${path(head)}Z`,
				fill: this.colours.signal
			}));
		}
		spot(spot) {
			if (spot.closed !== void 0) return this.closed(spot, spot.closed);
			const node = spot.node;
			if (node === void 0) return "";
			const share = node.row === void 0 ? void 0 : this.activity?.rows[node.row];
			const isGone = node.gone !== void 0 || node.row !== void 0 && this.below.has(node.row);
			const fill = isGone || share === void 0 ? this.colours.element : activityColour(share);
			const ink = isGone ? this.colours.quiet : share === void 0 ? this.colours.ink : lettersOn(fill);
			const parts = [tag("title", {}, escaped(this.words(spot, share)))];
			if (isJunction(node) || isTwoPort(node.kind)) {
				parts.push(this.letters(spot.label, spot.x, spot.y + 4.5, {
					size: 13,
					bold: isJunction(node),
					fill: ink
				}));
				if (spot.note !== "") parts.push(this.letters(spot.note, spot.x, spot.y + spot.height / 2 + 10, {
					size: 10,
					fill: this.colours.quiet
				}));
			} else {
				const information = isInformation(node.kind);
				const outline = isGone ? this.colours.quiet : information ? this.colours.signal : this.colours.ink;
				parts.push(tag("rect", {
					x: spot.x - spot.width / 2,
					y: spot.y - spot.height / 2,
					width: spot.width,
					height: spot.height,
					rx: node.row !== void 0 ? spot.height / 2 : information ? 2 : 0,
					fill: node.row !== void 0 || information ? fill : "none",
					stroke: node.row !== void 0 || information ? outline : "none",
					"stroke-width": 1.2,
					...isGone ? { "stroke-dasharray": "4 3" } : {}
				}), this.letters(spot.label, spot.x, spot.y + 4.3, {
					size: 12,
					fill: ink
				}));
			}
			if (node.gone !== void 0) parts.push(this.badge(spot, node.gone.sign));
			const row = node.row === void 0 ? {} : { "data-row": node.row };
			return tag("g", {
				class: isGone ? "node gone" : "node",
				"data-id": node.path,
				"data-kind": node.kind,
				...row
			}, parts.join(""));
		}
		closed(spot, closed) {
			const hasShare = this.activity !== void 0 && closed.rows > 0;
			const fill = hasShare ? activityColour(closed.share) : this.colours.closed;
			const ink = hasShare ? lettersOn(fill) : this.colours.ink;
			const [x, y] = [spot.x - spot.width / 2, spot.y - spot.height / 2];
			const parts = [
				tag("title", {}, escaped(hasShare ? `${closed.path}: ${percent(closed.share)} of the activity` : closed.path)),
				tag("rect", {
					x,
					y,
					width: spot.width,
					height: spot.height,
					rx: 8,
					fill,
					stroke: this.colours.frameLine,
					"stroke-width": 1.4
				}),
				this.letters(`▸ ${spot.label}`, spot.x, spot.y + (spot.note === "" ? 4.5 : -2), {
					size: 13,
					bold: true,
					fill: ink
				})
			];
			if (spot.note !== "") parts.push(this.letters(spot.note, spot.x, spot.y + 14, {
				size: 10,
				fill: ink
			}));
			return tag("g", {
				class: "closed",
				"data-group": closed.path
			}, parts.join(""));
		}
		/** The sign of what stands in the place of an element that is gone. */
		badge(spot, sign) {
			const width = widthOf(sign, 10, true) + 8;
			const [x, y] = [spot.x + spot.width / 2 - 4, spot.y - spot.height / 2 - 6];
			return tag("rect", {
				x: x - width / 2,
				y: y - 7,
				width,
				height: 14,
				rx: 3,
				fill: this.colours.paper,
				stroke: this.colours.quiet
			}) + this.letters(sign, x, y + 3.5, {
				size: 10,
				bold: true,
				fill: this.colours.ink
			});
		}
		/** The sign of a bond whose strokes contradict one another. */
		cross(at) {
			return tag("path", {
				class: "cross",
				d: `M${number(at.x - 5)} ${number(at.y - 5)}l10 10m0 -10l-10 10`,
				stroke: this.colours.stroke.conflict,
				"stroke-width": 2.2,
				fill: "none"
			});
		}
		words(spot, share) {
			const node = spot.node;
			if (node === void 0) return "";
			const activity = share === void 0 ? "" : `, ${percent(share)} of the activity`;
			const gone = node.gone === void 0 ? "" : `, gone: ${node.gone.meaning}`;
			return `${node.path} (${node.kind})${activity}${gone}`;
		}
		letters(text, x, y, look) {
			return tag("text", {
				x,
				y,
				fill: look.fill,
				"font-size": look.size,
				"text-anchor": look.anchor ?? "middle",
				...look.bold === true ? { "font-weight": 700 } : {},
				textLength: widthOf(text, look.size, look.bold),
				lengthAdjust: "spacingAndGlyphs"
			}, escaped(text));
		}
	};
	var percent = (share) => `${(100 * share).toPrecision(3)} %`;
	var path = (points) => points.map((point, i) => `${i === 0 ? "M" : "L"}${number(point.x)} ${number(point.y)}`).join("");
	/** The middle of the longest stretch of a line. */
	function halfway(points) {
		let [best, longest] = [points[0], -1];
		points.slice(1).forEach((point, i) => {
			const from = points[i];
			const length = Math.hypot(point.x - from.x, point.y - from.y);
			if (length > longest) [best, longest] = [{
				x: (from.x + point.x) / 2,
				y: (from.y + point.y) / 2
			}, length];
		});
		return best;
	}
	// src/graph/fold.ts
	/** What is visible when some groups are open and the others closed: a closed group stands for all that is in it. */
	var Hierarchy = class {
		groups;
		constructor(picture) {
			this.groups = new Map(picture.groups.map((group) => [group.path, group]));
		}
		/** The groups around a group, itself included, the root first. */
		lineage(path) {
			const found = [];
			for (let at = this.groups.get(path); at !== void 0; at = this.groups.get(at.parent)) {
				found.unshift(at);
				if (at.path === "") break;
			}
			return found;
		}
	};
	/** The groups down to a depth; the root alone is depth 0. */
	function openTo(picture, depth) {
		const hierarchy = new Hierarchy(picture);
		return new Set(picture.groups.map((group) => group.path).filter((path) => hierarchy.lineage(path).length - 1 <= depth));
	}
	/**
	* Fold a picture: only what is in open groups is visible, and closed groups in them. Rows below a threshold count as gone
	* where a closed group tells how many are kept.
	*/
	function fold(picture, open, below = /* @__PURE__ */ new Set()) {
		const hierarchy = new Hierarchy(picture);
		const shownAs = /* @__PURE__ */ new Map();
		const standing = /* @__PURE__ */ new Map();
		const nodes = [];
		for (const node of picture.nodes) {
			const shut = hierarchy.lineage(node.group).find((group) => group.path !== "" && !open.has(group.path));
			if (shut === void 0) {
				shownAs.set(node.path, node.path);
				nodes.push(node);
			} else {
				shownAs.set(node.path, `group:${shut.path}`);
				const inside = standing.get(shut.path) ?? [];
				inside.push(node);
				standing.set(shut.path, inside);
			}
		}
		const isShown = (group) => hierarchy.lineage(group.path).every((at) => at.path === "" || open.has(at.path));
		const closed = picture.groups.filter((group) => standing.has(group.path)).map((group) => closedGroup(picture, group, standing.get(group.path) ?? [], below));
		const place = (path) => shownAs.get(path) ?? path;
		const bonds = picture.bonds.map((bond) => ({
			bond,
			tail: place(bond.tail),
			head: place(bond.head)
		})).filter(({ tail, head }) => tail !== head);
		const seen = /* @__PURE__ */ new Set();
		const signals = [];
		for (const signal of picture.signals) {
			const [from, to] = [place(signal.from), place(signal.to)];
			const key = `${from}>${to}`;
			if (from === to || seen.has(key)) continue;
			seen.add(key);
			signals.push({
				from,
				to
			});
		}
		return {
			picture,
			groups: picture.groups.filter(isShown),
			nodes,
			closed,
			bonds,
			signals
		};
	}
	function closedGroup(picture, group, inside, below) {
		const rows = /* @__PURE__ */ new Map();
		for (const node of inside) {
			if (!isEnergetic(node.kind) || node.row === void 0) continue;
			rows.set(node.row, (rows.get(node.row) ?? false) || node.gone === void 0 && !below.has(node.row));
		}
		let share = 0;
		for (const row of rows.keys()) share += picture.activity?.rows[row] ?? 0;
		return {
			path: group.path,
			name: group.name,
			group: group.parent,
			rows: rows.size,
			kept: [...rows.values()].filter(Boolean).length,
			share
		};
	}
	// src/graph/layout.ts
	var RADIUS = 11;
	var OPTIONS = {
		"elk.algorithm": "layered",
		"elk.hierarchyHandling": "INCLUDE_CHILDREN",
		"elk.edgeRouting": "ORTHOGONAL",
		"elk.layered.nodePlacement.strategy": "NETWORK_SIMPLEX",
		"elk.layered.mergeEdges": "false",
		"elk.spacing.nodeNode": "22",
		"elk.spacing.edgeNode": "14",
		"elk.spacing.edgeEdge": "12",
		"elk.layered.spacing.nodeNodeBetweenLayers": "40",
		"elk.layered.spacing.edgeNodeBetweenLayers": "18",
		"elk.layered.spacing.edgeEdgeBetweenLayers": "12",
		"elk.spacing.portPort": String(16),
		"elk.portAlignment.default": "CENTER",
		"elk.json.shapeCoords": "ROOT",
		"elk.json.edgeCoords": "ROOT"
	};
	/** Place what is visible. */
	async function place(visible, placer, direction = "RIGHT") {
		const figures = figuresOf(visible);
		const figureOf = /* @__PURE__ */ new Map();
		for (const figure of figures) for (const spot of figure.spots) figureOf.set(spot.id, figure);
		const inner = new Set(figures.flatMap((figure) => figure.inner));
		const outer = visible.bonds.filter((bond) => !inner.has(bond));
		const boxes = /* @__PURE__ */ new Map();
		for (const group of visible.groups) boxes.set(group.path, {
			id: `frame:${group.path}`,
			children: [],
			layoutOptions: {
				"elk.padding": group.path === "" ? "[top=8,left=8,bottom=8,right=8]" : "[top=32,left=14,bottom=14,right=14]",
				"elk.nodeSize.constraints": "MINIMUM_SIZE",
				"elk.nodeSize.minimum": `(${Math.ceil(widthOf(group.name, 13, true)) + 40}, 40)`
			}
		});
		for (const group of visible.groups) if (group.path !== "") boxes.get(group.parent)?.children?.push(boxes.get(group.path));
		for (const figure of figures) boxes.get(figure.group)?.children?.push({
			id: figure.id,
			width: figure.width,
			height: figure.height
		});
		const root = boxes.get("") ?? {
			id: "frame:",
			children: []
		};
		const edges = outer.map((bond, number) => ({
			id: `bond:${number}`,
			sources: [figureOf.get(bond.tail)?.id ?? bond.tail],
			targets: [figureOf.get(bond.head)?.id ?? bond.head]
		}));
		const graph = {
			...root,
			id: "frame:",
			edges,
			layoutOptions: {
				...OPTIONS,
				...root.layoutOptions,
				"elk.direction": direction
			}
		};
		const drafted = await placer.layout(JSON.parse(JSON.stringify(graph)));
		return collected(visible, figures, outer, await placer.layout(withPorts(graph, drafted, figures)));
	}
	/**
	* The graph with a port for every end of a bond, on the side and in the order of a draft: ELK alone centres bonds on the
	* side of a figure, but its junction need not be in the middle.
	*/
	function withPorts(graph, drafted, figures) {
		const figureOf = new Map(figures.map((figure) => [figure.id, figure]));
		const corners = /* @__PURE__ */ new Map();
		const lines = /* @__PURE__ */ new Map();
		for (const box of everyBox(drafted)) {
			corners.set(box.id, box);
			for (const edge of box.edges ?? []) lines.set(edge.id, edge);
		}
		const sides = /* @__PURE__ */ new Map();
		for (const edge of graph.edges ?? []) {
			const section = lines.get(edge.id)?.sections?.[0];
			const [source, target] = [edge.sources[0], edge.targets[0]];
			if (section === void 0 || source === void 0 || target === void 0) continue;
			for (const [owner, port, at] of [[
				source,
				`${edge.id}:tail`,
				section.startPoint
			], [
				target,
				`${edge.id}:head`,
				section.endPoint
			]]) {
				const ends = sides.get(owner) ?? [];
				ends.push({
					port,
					at
				});
				sides.set(owner, ends);
			}
			edge.sources = [`${edge.id}:tail`];
			edge.targets = [`${edge.id}:head`];
		}
		for (const box of everyBox(graph)) {
			const figure = figureOf.get(box.id);
			const corner = corners.get(box.id);
			if (figure === void 0 || corner === void 0) continue;
			const ends = sides.get(box.id) ?? [];
			const isWest = ({ at }) => at.x < (corner.x ?? 0) + figure.width / 2;
			box.ports = [];
			for (const side of [ends.filter(isWest), ends.filter((end) => !isWest(end))]) {
				side.sort((a, b) => a.at.y - b.at.y);
				side.forEach((end, place) => {
					const y = figure.middle + 16 * (place - (side.length - 1) / 2);
					box.ports?.push({
						id: end.port,
						width: 0,
						height: 0,
						x: isWest(end) ? 0 : figure.width,
						y: Math.min(Math.max(y, 1), figure.height - 1),
						layoutOptions: { "elk.port.side": isWest(end) ? "WEST" : "EAST" }
					});
				});
			}
			box.layoutOptions = {
				...box.layoutOptions,
				"elk.portConstraints": "FIXED_POS"
			};
		}
		return graph;
	}
	function* everyBox(root) {
		const pending = [root];
		for (let box = pending.pop(); box !== void 0; box = pending.pop()) {
			yield box;
			pending.push(...box.children ?? []);
		}
	}
	function collected(visible, figures, outer, placed) {
		const corner = /* @__PURE__ */ new Map();
		const frames = [];
		const names = new Map(visible.groups.map((group) => [`frame:${group.path}`, group]));
		const lines = /* @__PURE__ */ new Map();
		const pending = [[placed, 0]];
		while (pending.length > 0) {
			const [box, depth] = pending.pop();
			const [x, y] = [box.x ?? 0, box.y ?? 0];
			corner.set(box.id, {
				x,
				y
			});
			const group = names.get(box.id);
			if (group !== void 0 && group.path !== "") frames.push({
				path: group.path,
				name: group.name,
				depth,
				x,
				y,
				width: box.width ?? 0,
				height: box.height ?? 0
			});
			for (const child of box.children ?? []) pending.push([child, depth + 1]);
			for (const edge of box.edges ?? []) {
				const section = edge.sections?.[0];
				if (section !== void 0) lines.set(edge.id, [
					section.startPoint,
					...section.bendPoints ?? [],
					section.endPoint
				]);
			}
		}
		frames.sort((a, b) => a.depth - b.depth || (a.path < b.path ? -1 : 1));
		const spots = /* @__PURE__ */ new Map();
		for (const figure of figures) {
			const at = corner.get(figure.id) ?? {
				x: 0,
				y: 0
			};
			for (const spot of figure.spots) spots.set(spot.id, {
				...spot,
				x: spot.x + at.x,
				y: spot.y + at.y
			});
		}
		const whole = (id, from, to) => {
			const line = lines.get(id);
			const [tail, head] = [spots.get(from), spots.get(to)];
			if (line === void 0 || tail === void 0 || head === void 0) throw new Error(`no way from ${from} to ${to}`);
			return tidy(reaching(reaching([...line].reverse(), tail).reverse(), head));
		};
		const bonds = outer.map((shown, number) => ({
			shown,
			points: whole(`bond:${number}`, shown.tail, shown.head)
		}));
		for (const figure of figures) for (const shown of figure.inner) {
			const [tail, head] = [spots.get(shown.tail), spots.get(shown.head)];
			if (tail !== void 0 && head !== void 0) bonds.push({
				shown,
				points: between(tail, head)
			});
		}
		const signals = [];
		for (const signal of visible.signals) {
			const [from, to] = [spots.get(signal.from), spots.get(signal.to)];
			if (from !== void 0 && to !== void 0) signals.push({
				signal,
				points: curve(from, to)
			});
		}
		return {
			width: placed.width ?? 0,
			height: placed.height ?? 0,
			frames,
			spots: [...spots.values()],
			bonds,
			signals
		};
	}
	/** A line that ends at the border of a figure, prolonged to the spot inside that it belongs to. */
	function reaching(line, spot) {
		const last = line[line.length - 1];
		const before = line[line.length - 2] ?? last;
		const isLevel = Math.abs(last.y - before.y) <= Math.abs(last.x - before.x);
		const points = [...line];
		if (spot.node !== void 0 && isJunction(spot.node)) {
			const [dx, dy] = [last.x - spot.x, last.y - spot.y];
			if (isLevel && Math.abs(dy) > 1.5) {
				const reach = Math.min(Math.abs(dx), 16 + Math.abs(dy));
				points.push({
					x: spot.x + Math.sign(dx) * reach,
					y: last.y
				});
			} else if (!isLevel && Math.abs(dx) > 1.5) {
				const reach = Math.min(Math.abs(dy), 16 + Math.abs(dx));
				points.push({
					x: last.x,
					y: spot.y + Math.sign(dy) * reach
				});
			}
			if (points.length === line.length) {
				points.push(isLevel ? {
					x: spot.x + Math.sign(dx) * RADIUS,
					y: last.y
				} : {
					x: last.x,
					y: spot.y + Math.sign(dy) * RADIUS
				});
				return points;
			}
			const from = points[points.length - 1];
			const length = Math.hypot(from.x - spot.x, from.y - spot.y) || 1;
			points.push({
				x: spot.x + (from.x - spot.x) * RADIUS / length,
				y: spot.y + (from.y - spot.y) * RADIUS / length
			});
			return points;
		}
		const limit = (value, centre, extent) => Math.min(Math.max(value, centre - extent), centre + extent);
		if (isLevel) {
			const side = Math.sign(last.x - spot.x) || 1;
			const y = limit(last.y, spot.y, Math.max(spot.height / 2 - 3, 0));
			if (Math.abs(y - last.y) > .5) points.push({
				x: spot.x + side * (spot.width / 2 + 8),
				y: last.y
			});
			points.push({
				x: spot.x + side * spot.width / 2,
				y
			});
		} else {
			const side = Math.sign(last.y - spot.y) || 1;
			const x = limit(last.x, spot.x, Math.max(spot.width / 2 - 3, 0));
			if (Math.abs(x - last.x) > .5) points.push({
				x: last.x,
				y: spot.y + side * (spot.height / 2 + 8)
			});
			points.push({
				x,
				y: spot.y + side * spot.height / 2
			});
		}
		return points;
	}
	/** The straight line between a junction and an element above or below it. */
	function between(tail, head) {
		const isUp = head.node !== void 0 && isJunction(head.node);
		const [junction, element] = isUp ? [head, tail] : [tail, head];
		const side = Math.sign(element.y - junction.y);
		const end = {
			x: element.x,
			y: element.y - side * element.height / 2
		};
		const length = Math.hypot(end.x - junction.x, end.y - junction.y) || 1;
		const start = {
			x: junction.x + (end.x - junction.x) * RADIUS / length,
			y: junction.y + (end.y - junction.y) * RADIUS / length
		};
		return isUp ? [end, start] : [start, end];
	}
	/** A curve between the sides of two spots that face each other. */
	function curve(from, to) {
		const [dx, dy] = [to.x - from.x, to.y - from.y];
		if (Math.abs(dx) - (from.width + to.width) / 2 >= Math.abs(dy) - (from.height + to.height) / 2) {
			const side = Math.sign(dx) || 1;
			const start = {
				x: from.x + side * from.width / 2,
				y: from.y
			};
			const end = {
				x: to.x - side * to.width / 2,
				y: to.y
			};
			const reach = side * Math.max(24, Math.abs(end.x - start.x) / 2.5);
			return [
				start,
				{
					x: start.x + reach,
					y: start.y
				},
				{
					x: end.x - reach,
					y: end.y
				},
				end
			];
		}
		const side = Math.sign(dy) || 1;
		const start = {
			x: from.x,
			y: from.y + side * from.height / 2
		};
		const end = {
			x: to.x,
			y: to.y - side * to.height / 2
		};
		const reach = side * Math.max(24, Math.abs(end.y - start.y) / 2.5);
		return [
			start,
			{
				x: start.x,
				y: start.y + reach
			},
			{
				x: end.x,
				y: end.y - reach
			},
			end
		];
	}
	/** The same line without points that change nothing. */
	function tidy(line) {
		const found = [];
		for (const point of line) {
			const last = found[found.length - 1];
			if (last !== void 0 && Math.hypot(point.x - last.x, point.y - last.y) < .25) continue;
			const before = found[found.length - 2];
			if (last !== void 0 && before !== void 0) {
				const turn = (last.x - before.x) * (point.y - last.y) - (last.y - before.y) * (point.x - last.x);
				if (Math.abs(turn) < 1e-6) found.pop();
			}
			found.push(point);
		}
		return found;
	}
	// src/static.ts
	/**
	* Drawing without a page: one function for JavaScript engines that have no document, such as the one inside Python.
	*
	* The worker of ELK is loaded before this script and left as it is; here it runs in place.
	*/
	/** The SVG text of a picture; both arguments are JSON texts. */
	async function drawPicture(document, options) {
		const picture = JSON.parse(document);
		const wanted = JSON.parse(options);
		const open = openTo(picture, wanted.depth);
		for (const path of wanted.open) open.add(path);
		const placer = new import_elk_api.default({ workerFactory: () => new ElkWorker() });
		return draw(picture, await place(fold(picture, open), placer, wanted.direction), {
			theme: wanted.theme,
			legend: wanted.legend
		});
	}
	Object.assign(globalThis, { drawPicture });
})();
