"""The studio: a page in the browser, served from this machine, to see models, run them and reduce them.

`server` starts it; `app` has its routes; `guard` lets in only who was given the address. What runs models, and with
them other people's code, does so in processes of its own (`worker`), so that the server outlives whatever they do.
"""
