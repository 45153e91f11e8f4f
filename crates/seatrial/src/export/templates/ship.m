{{routines}}function next = runge_kutta(state, input, seconds, p)
% The state `seconds` later by a step of order 4, while the inputs are held.
shares = [0, 0.5, 0.5, 1];
weights = [1, 2, 2, 1];
rates = [0, 0, 0];
total = [0, 0, 0];
for stage = 1:4
    here = state + rates * (shares(stage) * seconds);
    rates = accelerations(here, input, p);
    total = total + rates * weights(stage);
end
next = state + total * (seconds / 6);
end

function next = step(state, input, p)
% The state one sample after `state`, while the inputs are held.
next = reshape(state, 1, 3);
for i = 1:{{steps}}  % steps of Runge and Kutta's method in a sample
    next = runge_kutta(next, input, (1 / {{rate}}) / {{steps}}, p);
end
end

