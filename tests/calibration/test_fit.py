"""The fit against closed forms: linear problems with exact covariance, coverage of
intervals, failing runs.
"""

import numpy as np
import pytest
from closed_forms import ClosedForm, data
from numpy.testing import assert_allclose, assert_array_equal
from scipy.stats import norm

from contbed.errors import ConvergenceError
from contbed.many.calibrate import fit as fitting
from contbed.many.calibrate import identify, posterior
from contbed.many.calibrate.fit import Problem, fit
from contbed.many.calibrate.settings import Posterior
from contbed.many.distributions import Distribution

QUANTILE = norm.ppf(0.95)
PRIORS = (
    Distribution(1.0, 9.0, even=True),  # from 1 to 9
    Distribution(2.0, 2.5, even=False),  # 2 +- 0.5
    Distribution(-4.0, -1.0, even=False),  # -4 +- 3
)
MATRIX = np.array(
    [
        [1.0, 2.0, 0.5],
        [0.3, -1.0, 2.0],
        [2.0, 0.1, 0.0],
        [1.0, 1.0, 1.0],
        [-1.0, 0.5, 0.2],
    ]
)
ERRORS = np.array([0.1, 0.2, 0.3, 0.1, 0.2])
TRUE = np.array([4.0, 2.2, -3.0])


def linear():
    return ClosedForm(lambda *keys: MATRIX @ np.array(keys), PRIORS)


def decay(t):
    return lambda a, b: a * np.exp(-b * t)


def exact_linear(values):
    """Keys and covariance in SI: the even prior tells nothing, the normal ones are
    rows of their own.
    """
    rows = np.vstack([MATRIX / ERRORS[:, None], [[0, 1 / 0.5, 0], [0, 0, 1 / 3.0]]])
    right = np.concatenate([values / ERRORS, [2.0 / 0.5, -4.0 / 3.0]])
    covariance = np.linalg.inv(rows.T @ rows)
    return covariance @ rows.T @ right, covariance


def test_a_linear_problem_has_its_exact_keys_and_covariance():
    values = MATRIX @ TRUE + np.array([0.05, -0.1, 0.2, 0.03, -0.1])
    found = fit(Problem(linear(), data(values, ERRORS), PRIORS))
    keys, covariance = exact_linear(values)
    slopes = np.array(
        [prior.slope(z) for prior, z in zip(PRIORS, found.z, strict=True)]
    )
    assert found.scatter == 1.0 and found.alike == 0.0 and found.converged
    # differences of a linear model are exact to rounding over the step, 1e-16/0.02; the
    # search stops at 1e-6
    assert_allclose(
        [p.value(z) for p, z in zip(PRIORS, found.z, strict=True)], keys, rtol=1e-6
    )
    assert_allclose(found.covariance * np.outer(slopes, slopes), covariance, rtol=1e-9)


def test_bands_of_a_linear_problem_are_exact():
    values = MATRIX @ TRUE
    found = fit(Problem(linear(), data(values, ERRORS), PRIORS))
    _, covariance = exact_linear(values)
    assert_allclose(
        found.bands(found.slopes),
        np.sqrt(np.diag(MATRIX @ covariance @ MATRIX.T)),
        rtol=1e-9,
    )


def test_the_profile_of_a_linear_problem_is_its_standard_error():
    measured = data(MATRIX @ TRUE, ERRORS)
    model = linear()
    problem = Problem(model, measured, PRIORS)
    found = fit(problem)
    for key in range(3):
        interval = identify.profile(problem, found, key)
        half = QUANTILE * np.sqrt(found.covariance[key, key])
        assert not interval.open_low and not interval.open_high
        # the search for an end stops within 2 % of the half width
        assert_allclose(
            [interval.low, interval.high],
            found.z[key] + half * np.array([-1, 1]),
            atol=0.02 * half,
        )


def test_samples_of_a_linear_problem_have_its_mean_and_covariance():
    pytest.importorskip("emcee")
    measured, model = data(MATRIX @ TRUE, ERRORS), linear()
    problem = Problem(model, measured, PRIORS)
    found = fit(problem)
    samples = posterior.sample(
        problem, found, Posterior(walkers=40, steps=4500, seed=3)
    )
    spread = np.sqrt(np.diag(found.covariance))
    # 135,000 samples of which one in some 40 is independent: 1.7 % of a mean in its
    # deviation; nearly five times that is allowed, as which samples are drawn depends
    # on the last digits of the libraries
    assert_allclose((samples.z.mean(axis=0) - found.z) / spread, 0.0, atol=0.08)
    assert_allclose(
        np.cov(samples.z.T) / np.outer(spread, spread),
        found.covariance / np.outer(spread, spread),
        atol=0.1,
    )
    again = posterior.sample(problem, found, Posterior(walkers=40, steps=20, seed=3))
    assert_array_equal(
        again.z,
        posterior.sample(problem, found, Posterior(walkers=40, steps=20, seed=3)).z,
    )


def test_keys_are_recovered_and_nine_of_ten_intervals_hold_them():
    t, random = np.linspace(0.0, 3.0, 20), np.random.default_rng(11)
    priors = (
        Distribution(0.5, 3.0, even=True),
        Distribution(1.0, 2.0, even=False, logarithmic=True),
    )
    error, repetitions, held = 0.05, 1000, np.zeros(2)
    for _ in range(repetitions):
        # the truth is drawn as the priors say, as only then they are right on average
        truth = np.array([float(prior(np.array(random.random()))) for prior in priors])
        model = ClosedForm(decay(t), priors)
        values = decay(t)(*truth) + error * random.standard_normal(20)
        found = fit(Problem(model, data(values, error), priors))
        scaled = np.array(
            [
                float(prior.scaled(value))
                for prior, value in zip(priors, truth, strict=True)
            ]
        )
        half = found.quantile * np.sqrt(np.diag(found.covariance))
        held += np.abs(scaled - found.z) <= half
    # 90 % of 1000 scatter with a standard deviation of 9.5, three of which are allowed
    assert np.all(held >= 870) and np.all(held <= 930), held


@pytest.mark.parametrize(
    ("stated", "correlation"),
    [(0.4, 0.0), (1.0, 0.8)],
    ids=["errors too small", "neighbours alike"],
)
def test_intervals_hold_the_keys_where_errors_are_not_as_stated(stated, correlation):
    t, random = np.linspace(0.0, 3.0, 100), np.random.default_rng(5)
    priors = (Distribution(0.0, 5.0, even=True), Distribution(0.0, 5.0, even=True))
    truth, error, repetitions, held = np.array([1.5, 0.7]), 0.05, 100, np.zeros(2)
    for _ in range(repetitions):
        noise = random.standard_normal(100)
        for k in range(1, 100):
            noise[k] = (
                correlation * noise[k - 1] + np.sqrt(1.0 - correlation**2) * noise[k]
            )
        values = decay(t)(*truth) + error * noise
        measured = data(values, stated * error, np.zeros(100))
        found = fit(Problem(ClosedForm(decay(t), priors), measured, priors))
        scaled = np.array(
            [
                float(prior.scaled(value))
                for prior, value in zip(priors, truth, strict=True)
            ]
        )
        held += np.abs(scaled - found.z) <= found.quantile * np.sqrt(
            np.diag(found.covariance)
        )
    # as stated, 49 and 50 of 100 hold; the correlation is itself estimated from 100
    # values, which costs some percent
    assert np.all(held >= 80), held


def test_what_the_data_do_not_see_is_named_and_keeps_its_prior():
    priors = (
        Distribution(0.0, 2.0, even=True),
        Distribution(1.0, 1.5, even=False),
        Distribution(0.0, 1.0, even=False),
    )
    # only the sum of the first two, and nothing of the third
    model = ClosedForm(lambda a, b, c: (a + b) * np.ones(4) + 0.0 * c, priors)
    measured = data(np.full(4, 2.0), 0.01)
    problem = Problem(model, measured, priors)
    found = fit(problem)
    best, middle, least = identify.combinations(problem, found)
    assert best.seen and not middle.seen and not least.seen
    # per standard deviations of the priors, 1/sqrt(3) and 0.5
    length = np.hypot(1.0 / np.sqrt(3.0), 0.5)
    # root of four values
    assert_allclose(best.singular, 2.0 * length / 0.01, rtol=1e-9)
    assert best.named(["a", "b", "c"]) == "0.76 a +0.65 b"
    assert_allclose(found.covariance[2, 2], 1.0, rtol=1e-9)
    interval = identify.profile(problem, found, 2)
    assert_allclose([interval.low, interval.high], [-QUANTILE, QUANTILE], rtol=0.02)


def test_an_interval_that_meets_the_end_of_its_prior_is_open_there():
    priors = (Distribution(0.0, 1.0, even=True),)
    model = ClosedForm(lambda a: np.array([a, a]), priors)
    measured = data([0.9, 0.9], 0.2)
    problem = Problem(model, measured, priors)
    found = fit(problem)
    interval = identify.profile(problem, found, 0)
    assert interval.open_high and not interval.open_low
    assert_allclose(
        priors[0].value(interval.low),
        0.9 - QUANTILE * 0.2 / np.sqrt(2.0),
        atol=0.02 * 0.24,
    )


def test_runs_that_fail_do_not_lose_the_fit():
    t = np.linspace(0.0, 3.0, 20)
    priors = (Distribution(0.5, 3.0, even=True), Distribution(0.2, 3.0, even=True))
    # no result in three quarters of the priors, the middle among them
    model = ClosedForm(decay(t), priors, fails=lambda keys: keys[1] > 0.9)
    found = fit(Problem(model, data(decay(t)(1.3, 0.7), 0.01), priors))
    assert found.converged
    assert_allclose(
        [p.value(z) for p, z in zip(priors, found.z, strict=True)],
        [1.3, 0.7],
        rtol=1e-4,
    )


def test_a_fit_that_ends_where_runs_fail_has_not_converged():
    t = np.linspace(0.0, 3.0, 20)
    priors = (Distribution(0.5, 3.0, even=True), Distribution(0.2, 3.0, even=True))
    model = ClosedForm(decay(t), priors, fails=lambda keys: keys[1] > 0.7005)
    problem = Problem(model, data(decay(t)(1.3, 1.7), 0.01), priors)
    assert not fit(problem).converged


def test_priors_without_any_result_are_told():
    priors = (Distribution(0.5, 3.0, even=True),)
    model = ClosedForm(lambda a: np.array([a]), priors, fails=lambda keys: True)
    with pytest.raises(
        ConvergenceError,
        match="no run has a result in the middle of the priors or at 8 points",
    ):
        fit(Problem(model, data([1.0], 0.1), priors))


@pytest.mark.parametrize(
    "prior",
    [
        Distribution(2.0, 5.0, even=True),
        Distribution(-1e-3, -10.0, even=True, logarithmic=True),
        Distribution(5.0, 5.2, even=False),
        Distribution(5.0, 6.5, even=False, logarithmic=True),
    ],
    ids=["even", "even in logarithm", "normal", "log-normal"],
)
def test_distributions_fit_together(prior):
    z = np.linspace(-1.7, 1.7, 7)
    assert_allclose(prior.scaled(prior.value(z)), z, atol=1e-12)
    slopes = (prior.value(z + 1e-6) - prior.value(z - 1e-6)) / 2e-6
    assert_allclose([prior.slope(each) for each in z], slopes, rtol=1e-6)
    u = (np.arange(200_000) + 0.5) / 200_000
    values = prior(u)
    # midpoint rule: the tails of the normal ones beyond the last point hold 1e-5 of the
    # variance
    assert_allclose(
        [prior.mean, prior.deviation], [values.mean(), values.std()], rtol=1e-3
    )
    if not prior.even:
        assert_allclose(prior(norm.cdf(z)), prior.value(z), rtol=1e-12)


def test_the_slopes_are_central_differences():
    priors = (Distribution(0.0, 2.0, even=True),)
    model = ClosedForm(lambda a: np.array([a**2]), priors)
    width = 2.0 / np.sqrt(12.0)
    _, slopes = fitting.derivatives(
        Problem(model, data([0.0], 1.0), priors), np.array([0.3]), np.array([0])
    )
    assert_allclose(
        slopes[0, 0], 2.0 * float(priors[0].value(0.3)) * width, rtol=1e-9
    )  # exact of a parabola


def test_a_place_without_any_result_has_no_slopes():
    priors = (Distribution(0.0, 2.0, even=True),)
    model = ClosedForm(lambda a: np.array([a]), priors, fails=lambda keys: True)
    with pytest.raises(
        ConvergenceError,
        match="no run beside the fitted point has a result where key 1 differs",
    ):
        fitting.derivatives(
            Problem(model, data([0.0], 1.0), priors), np.array([0.3]), np.array([0])
        )
