"""An independent computation of what the workspace computes, written from the paper. Shares no code with it."""
