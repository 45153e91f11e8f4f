{{step}}(const double *state, const double *input, const double *parameters, double *next)
{
    const double *p = parameters ? parameters : {{base}}_values;
{{unpack}}    const double du = {{surge}};
    const double dv = {{sway}};
    const double dr = {{yaw}};
    (void)input;
    next[0] = u + du;
    next[1] = v + dv;
    next[2] = r + dr;
}

