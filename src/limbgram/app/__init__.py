"""App: the clinic's app: an HTTP API over the library, and the client's pages beside it.

One file a resource: a handler parses, calls one function of the library, and replies. pydantic's
types stay here. `server.build` puts them together, `serving.serve` runs them on this machine,
`openapi` writes the API's description for the client.
"""
