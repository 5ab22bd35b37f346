"""Services: what the program does for whoever stands before one of its doors.

A service is a function and the request that it takes: a frozen dataclass that says of each field
what it means and what it may be. The command line, the app, the batch and Python build the same
request and call the same function; options, forms and checks are made of what it says of itself.
"""
