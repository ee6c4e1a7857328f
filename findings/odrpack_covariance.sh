#!/usr/bin/env bash
# odrpack: cov_beta is not the covariance of the estimates: sd_beta**2 is not its diagonal.
#
# Guess: sd_beta equals the square root of the diagonal of cov_beta; both are documented without a further factor, as standard
#   deviations and as covariance matrix of the estimated parameters.
# Version: odrpack 0.7.0 (the successor of the deprecated scipy.odr).
# Behaviour: sd_beta is scaled by the residual variance, cov_beta is not: sd_beta**2 = res_var * diag(cov_beta). The factor is 1
#   only if the weights are the inverse variances of the data and the model is right.
# Output: line through 50 points, scatter 0.1 in x and 0.5 in y. Unit weights: the root of the diagonal of cov_beta is 4.6 times
#   sd_beta. Weights 1/s^2: 1.1 times. Multiplying all weights by 100 divides cov_beta by 100 and leaves sd_beta.
# Why it matters: the uncertainty of a quantity that depends on several fitted constants (K1 and K2 of a stack test) needs the
#   covariance, and users who take sd_beta for one and cov_beta for the other mix two scales; with stresses in Pa and unit
#   weights cov_beta is that of a scatter of 1 Pa.
# Remedy: res_var * cov_beta.
. "$(dirname "$0")/environment" odrpack==0.7.0 numpy==2.4.6
python - <<'EOF'
import numpy as np
from odrpack import odr_fit

random = np.random.default_rng(1)
exact = np.linspace(0, 10, 50)
y = 2 * exact + 1 + random.normal(0, 0.5, 50)
x = exact + random.normal(0, 0.1, 50)


def ratio(model, start, **weights):
    """Return the root of the diagonal of cov_beta divided by sd_beta, and sd_beta."""
    fit = odr_fit(model, x, y, np.array(start), **weights)
    ratios = np.sqrt(np.diag(fit.cov_beta)) / fit.sd_beta
    if not np.allclose(ratios, fit.res_var**-0.5, rtol=1e-9):
        raise SystemExit(f"changed: ratios {ratios} with the residual variance {fit.res_var}")
    print(weights, ratios, fit.sd_beta)
    return ratios[0], fit.sd_beta


for model, start in (
    (lambda x, b: b[0] * x + b[1], [1.0, 0.0]),
    (lambda x, b: b[0] * np.sinh(b[1] * x) + b[2], [1.0, 0.1, 0.0]),
):
    unit, _ = ratio(model, start)
    variances, deviations = ratio(model, start, weight_x=1 / 0.1**2, weight_y=1 / 0.5**2)
    scaled, same = ratio(model, start, weight_x=100 / 0.1**2, weight_y=100 / 0.5**2)
    if not (unit > 4 and 0.8 < variances < 1.3 and np.isclose(scaled, variances / 10, rtol=1e-4)):
        raise SystemExit(f"changed: {unit}, {variances}, {scaled}")
    if not np.allclose(deviations, same, rtol=1e-4):
        raise SystemExit(f"changed: {deviations}, {same}")
print("as stated")
EOF
