# Flags of the stages. `seatrial run` reads this file, and make does where the repository is at hand.
# Length between perpendiculars [m], for the figures of merit.
LENGTH_M = 100
