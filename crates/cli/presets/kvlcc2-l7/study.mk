# Flags of the stages, where they are to differ from the usual ones.
# Length between perpendiculars [m], for the figures of merit.
LENGTH_M = 7
