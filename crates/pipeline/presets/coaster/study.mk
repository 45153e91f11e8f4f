# Flags of the stages.
# Length between perpendiculars [m], for the figures of merit.
LENGTH_M = 100
