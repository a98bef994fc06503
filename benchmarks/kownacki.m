% The paper's procedure in Octave: fminsearch on the cost of one filter pass.
% The caller puts FOLDER in front of this; it holds the record and the weights, one column each.

function total = cost(p, T, z, S, lagw, poww)
  R = exp(p(1)); Q = exp(p(2)); q = Q * T^2;
  F = [1 T; 0 1]; x = [0; 0]; P = ones(2); n = numel(z); y = zeros(n, 1);
  for k = 1:n
    x = F * x;
    P = F * P * F' + q * eye(2);
    K = P(:, 1) / (P(1, 1) + R);
    x = x + K * (z(k) - x(1));
    P = P - K * P(1, :);
    y(k) = x(1);
  end
  total = sum(lagw .* max(S - y, 0) .^ 2) + sum(poww .* y .^ 2);
end

data = dlmread(fullfile(FOLDER, "data.txt"));
start = dlmread(fullfile(FOLDER, "start.txt"));
call = @(p) cost(p, start(3), data(:, 1), data(:, 2), data(:, 3), data(:, 4));
first = call(log(start(1:2)));
began = tic;
[found, value, flag, info] = fminsearch(call, log(start(1:2)), optimset("MaxFunEvals", start(4)));
printf("%.17g %.17g %d\n", first, toc(began), info.funcCount);
