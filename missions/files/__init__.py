"""Files of aircraft and missions: strict YAML in, with the line of every mistake; outputs whole.

* ``yaml``: documents that remember lines and columns; ``validation``: the mistakes of a document
* ``overrides``: other values than the file's; ``shipped``: files that come with the packages
* ``writing``: files and folders that appear whole or not at all; ``errors``: mistakes of the user
* ``tables``: numbers in columns, with the line of every row
"""
