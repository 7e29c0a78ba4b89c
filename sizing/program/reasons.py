def violations_of(*a):
    return ()


def unlifted(*a):
    return 0
