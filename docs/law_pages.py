"""Makes the page of laws: every element of the library with its equations, as the program has read them."""

from importlib import import_module
from pathlib import Path
from typing import Any

import propermodel as pm
from propermodel.modelling.elements import ELEMENTS
from propermodel.modelling.model import PowerSource, Resistive, Storage, TwoPort
from propermodel.modelling.tracing import trace

PAGE = Path(__file__).parent / "reference" / "laws.md"
DOMAINS = {
    "Translation": "mechanics.translation",
    "Rotation": "mechanics.rotation",
    "Planar mechanics": "mechanics.planar",
    "Hydraulics": "hydraulics",
    "Electricity": "electrical",
    "Heat": "thermal",
    "Heat as a pseudo bond": "pseudo_thermal",
}
HEAD = """# The laws of the library

What every element imposes on its ports, as the program has read it from the library. Where a port has a line for effort
and one for flow, either causality is offered. Names without a dot are parameters, inputs and coordinates of it.
"""


def setup(app: Any) -> dict[str, bool]:
    """Register with Sphinx."""
    app.connect("builder-inited", lambda _: write_laws())
    return {"parallel_read_safe": True}


def write_laws() -> None:
    """One section for each domain, one entry for each element."""
    text = [HEAD]
    for title, module in DOMAINS.items():
        text.append(f"## {title}\n")
        shelf = import_module(f"propermodel.library.{module}")
        for name in shelf.__all__:
            component = getattr(shelf, name)
            if isinstance(component, type) and issubclass(component, ELEMENTS):
                lines = "\n".join(laws_of(component))
                text.append(f"**{name}** ({kind_of(component)}, {ports_of(component)})\n\n```text\n{lines}\n```\n")
    new = "\n".join(text)
    if not PAGE.exists() or PAGE.read_text(encoding="utf-8") != new:
        PAGE.write_text(new, encoding="utf-8")


def kind_of(component: type[pm.Component]) -> str:
    """The kind of element in words."""
    base = next(kind for kind in ELEMENTS if issubclass(component, kind)).__name__
    return "".join(f" {letter.lower()}" if letter.isupper() else letter for letter in base).strip()


def ports_of(component: type[pm.Component]) -> str:
    """The ports of the element itself, with the flanges or pins that each lies between."""
    ports = {name: port for name, port in component.declarations.items() if isinstance(port, pm.Port)}
    names = {id(port): name for name, port in ports.items()}
    outer = {names[id(end)] for port in ports.values() for end in port.between or ()}
    shown = []
    for name, port in ports.items():
        if name not in outer:
            ends = " and ".join(f"`{names[id(end)]}`" for end in port.between or ())
            shown.append(f"`{name}` between {ends}" if ends else f"`{name}`")
    return "port " + ", ".join(shown) if len(shown) == 1 else "ports " + ", ".join(shown)


def laws_of(component: type[pm.Component]) -> list[str]:
    """The equations of an element."""
    match trace(component, component()):
        case Resistive(laws=laws, implicit=implicit):
            explicit = [f"{r.port}.{r.variable} = {r.value}" for law in laws for r in law.results]
            return [*explicit, *(f"0 = {residual}" for residual in implicit)]
        case Storage() as storage:
            own = {coordinate.name for coordinate in storage.coordinates}
            variable = "effort" if storage.kind.value == "C" else "flow"
            content = "displacement" if variable == "effort" else "momentum"
            stored = [f"{port}.{content} = {law}" for port, law in storage.stored if str(law) not in own]
            outputs = [f"{port}.{variable} = {law}" for port, law in storage.outputs]
            energy = str(storage.energy)
            return [*stored, *outputs, f"energy = {energy}" if len(energy) < 300 else "energy: see the class"]
        case PowerSource(value=value):
            return [f"{'effort' if issubclass(component, pm.EffortSource) else 'flow'} = {value}"]
        case TwoPort(modulus=modulus):
            return [f"modulus = {modulus}"]
    raise TypeError(f"{component.__name__} is no element")
