# Flags of the stages, where they are to differ from the usual ones.
