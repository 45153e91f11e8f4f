# Weights of what the states have gained after one, two, ... own steps.
WEIGHTS = ({{weights}},)


def step(state, inputs, parameters=PARAMETERS):
    """The state one sample after `state`, while the `inputs` are held."""
    here, gained = state, (0.0, 0.0, 0.0)
    for weight in WEIGHTS:
        here = own_step(here, inputs, parameters)
        gained = [sum_ + (own - first) * weight for sum_, own, first in zip(gained, here, state)]
    return tuple(first + sum_ for first, sum_ in zip(state, gained))


