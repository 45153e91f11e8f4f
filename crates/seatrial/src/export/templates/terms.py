def {{step}}(state, inputs, parameters=PARAMETERS):
    """The state one {{sample}} after `state`, while the `inputs` are held."""
    p = parameters
{{unpack}}    du = (
        {{surge}}
    )
    dv = (
        {{sway}}
    )
    dr = (
        {{yaw}}
    )
    return (u + du, v + dv, r + dr)


