# Figures of merit need the length between perpendiculars [m].
LENGTH_M = 100
