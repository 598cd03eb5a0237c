function [torque, s] = motor_step(s, voltage)
@HEADER@
%
% Holds a voltage (V) for c.STEP_S and gives the mean torque (N m) on the output shaft, whose inertia is c.OUTPUT_INERTIA_KG_M2.
% The state at rest:
%   s = struct('y', zeros(1, @STATE@), 'load_nm', 0, 'history', zeros(1, @HISTORY@));
% y has @NAMES@.
% Output shaft: angle s.y(@OUTPUT1@) in rad, speed s.y(@OUTPUT2@) in rad/s; the encoder sees s.y(@ENCODER1@). load_nm is the external
% torque on the output shaft, an input; history has the delayed commands, the newest last.
@CONSTANTS@
    before = s.y(@OUTPUT2@);
    s.history = [s.history(2:end), voltage];
    s.y = hold(c, s.y, command(c, s.history(1)), s.load_nm, c.LATE_S);
    s.y = hold(c, s.y, command(c, s.history(2)), s.load_nm, c.STEP_S - c.LATE_S);
    torque = c.OUTPUT_INERTIA_KG_M2 * (s.y(@OUTPUT2@) - before) / c.STEP_S - s.load_nm;
end

function y = hold(c, y, u, load, span_s)
    % Advances with a voltage held.
    steps = ceil(span_s / c.INNER_S - 1e-9);
    for n = 1:steps
        y = inner(c, y, u, load, span_s / steps);
    end
end

function y = inner(c, y, u, load, span_s)
    % One inner step, divided at events: 8 at most, later ones are applied at its end.
    for n = 1:8
        m = mode(c, y, u, load);
        before = events(c, y, m);
        stop = runge_kutta(c, y, m, span_s);
        after = events(c, stop, m);
        k = 0;
        share = 1.0;
        for j = 1:numel(before)
            if after(j) < 0 && after(j) < before(j)
                at = 0.0;
                if before(j) > 0
                    at = before(j) / (before(j) - after(j));
                end
                if k == 0 || at < share
                    k = j;
                    share = at;
                end
            end
        end
        if k > 0 && n < 8
            % False position, or bisection from an event at the start, six iterations: it lies between early and late.
            early = 0.0;
            late = 1.0;
            first = before(k);
            last = after(k);
            for j = 1:6
                share = 0.5 * (early + late);
                if first > 0
                    share = early + (late - early) * first / (first - last);
                end
                stop = runge_kutta(c, y, m, share * span_s);
                after = events(c, stop, m);
                if after(k) <= 0
                    late = share;
                    last = after(k);
                end
                if after(k) >= 0
                    early = share;
                    first = after(k);
                end
            end
        end
        y = snap(c, stop, m, k - 1);
        if k == 0
            return;
        end
        span_s = span_s * (1.0 - share);
    end
end

function stop = runge_kutta(c, y, m, span_s)
    % One Runge-Kutta step of fourth order within a mode.
    k1 = rates(c, y, m);
    k2 = rates(c, y + 0.5 * span_s * k1, m);
    k3 = rates(c, y + 0.5 * span_s * k2, m);
    k4 = rates(c, y + span_s * k3, m);
    stop = y + span_s / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
end

function r = pick(condition, a, b)
    if condition
        r = a;
    else
        r = b;
    end
end

function u = command(c, u)
    % What reaches the driver.
    u = @COMMAND@;
end

@FUNCTIONS@
