function model = {{base}}()
%{{base}}  A ship's manoeuvring model, for MATLAB and Octave.
%
%   model = {{base}}();
%   x = [2, 0, 0];                                            % u, v [m/s], r [rad/s]
%   x = model.step(x, row, model.parameters)                  % a sample later, one value of each of model.inputs held
%   states = model.simulate(rows, x, model.parameters)        % a row per state, one more than rows of inputs
%   model.within_ranges(x, row)                               % whether the model is known to hold there
%   model.outside(x, row)                                     % the names of what is outside
%
{{header}}
model.vessel = {{vessel}};
model.made_from = {{made_from}};
model.sample_rate_hz = {{rate}};  % {{rate_holds}}
model.step_s = 1 / model.sample_rate_hz;
model.states = { {{states}} };
model.inputs = { {{inputs}} };  % in this order in every row of inputs

model.parameters = struct();
model.standard_errors = struct();  % NaN where it is not known
{{parameters}}
model.units = struct();
{{units}}
model.names = struct();  % how the model's file calls what cannot be called so here
{{names}}
model.ranges = struct();  % least and largest value: {{ranges_are}}
{{ranges}}
model.step = @step;
model.simulate = @simulate;
model.outside = @(state, input) outside(model, state, input);
model.within_ranges = @(state, input) isempty(outside(model, state, input));
end

{{functions}}function states = simulate(inputs, initial, p)
% The states from `initial` on, one more than rows of `inputs`.
states = zeros(size(inputs, 1) + 1, 3);
states(1, :) = initial;
for k = 1:size(inputs, 1)
    states(k + 1, :) = step(states(k, :), inputs(k, :), p);
end
end

function names = outside(model, state, input)
% The names of states and inputs that are outside the range of validity.
names = {};
channels = [model.states, model.inputs];
values = [reshape(state, 1, []), reshape(input, 1, [])];
for k = 1:numel(channels)
    if isfield(model.ranges, channels{k})
        range = model.ranges.(channels{k});
        if ~(range(1) <= values(k) && values(k) <= range(2))
            names{end + 1} = channels{k};
        end
    end
end
end
