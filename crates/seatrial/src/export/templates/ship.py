# Steps of Runge and Kutta's method in a sample.
STEPS = {{steps}}


{{routines}}def runge_kutta(state, inputs, seconds, p):
    """The state `seconds` later by a step of order 4, while the `inputs` are held."""
    rates, total = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    for share, weight in ((0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0)):
        here = [own + rate * (share * seconds) for own, rate in zip(state, rates)]
        rates = accelerations(here, inputs, p)
        total = [own + rate * weight for own, rate in zip(total, rates)]
    return tuple(own + rate * (seconds / 6.0) for own, rate in zip(state, total))


def step(state, inputs, parameters=PARAMETERS):
    """The state one sample after `state`, while the `inputs` are held."""
    for _ in range(STEPS):
        state = runge_kutta(state, inputs, STEP_S / STEPS, parameters)
    return state


