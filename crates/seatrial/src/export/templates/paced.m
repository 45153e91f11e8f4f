function next = step(state, input, p)
% The state one sample after `state`, while the inputs are held.
weights = [{{weights}}];  % of what the states have gained after one, two, ... own steps
start = reshape(state, 1, 3);
here = start;
gained = [0, 0, 0];
for k = 1:numel(weights)
    here = own_step(here, input, p);
    gained = gained + (here - start) * weights(k);
end
next = start + gained;
end

