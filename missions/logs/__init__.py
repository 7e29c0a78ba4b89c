"""Logs of real flights: ``csv`` and ``px4_ulog`` read them, ``table`` checks what they hold."""
