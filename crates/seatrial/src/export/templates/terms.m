function next = {{step}}(state, input, p)
% The state one {{sample}} after `state`, while the inputs are held.
{{unpack}}du = {{surge}};
dv = {{sway}};
dr = {{yaw}};
next = [u + du, v + dv, r + dr];
end

