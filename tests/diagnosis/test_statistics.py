"""Statistics of the diagnosis against textbook formulas, brute force and Monte Carlo."""

import numpy as np
import pytest
from scipy import integrate, special, stats

from ecm_fast.data.measurements import Measurements
from ecm_fast.diagnosis.problem.holdout import lock
from ecm_fast.diagnosis.proof.localization import scan
from ecm_fast.diagnosis.statistics.evidence import EvidenceMatrix
from ecm_fast.diagnosis.statistics.lack_of_fit import null_quantile, score_test, trend_test
from ecm_fast.diagnosis.statistics.priors import Priors, size_factor
from ecm_fast.diagnosis.statistics.robust_noise import NoiseFit, RowOrder, _scale, clean, orthonormal, removal

pytestmark = pytest.mark.slow

ALL = np.zeros(3, dtype=bool)


@pytest.fixture
def system():
    rng = np.random.default_rng(1)
    nuisances, signatures = rng.standard_normal((40, 3)), rng.standard_normal((40, 6))
    residual = rng.standard_normal(40) + 2.0 * signatures[:, 1] + nuisances @ [5.0, -3.0, 1.0]
    return residual, nuisances, signatures


ONE_SIDED = np.arange(6) % 2 == 0


def likelihood(residual, nuisances, signatures):
    """Return the density ratio of what is orthogonal to the nuisances, as a function of sizes in prior deviations."""
    rest = np.linalg.svd(nuisances)[0][:, nuisances.shape[1] :].T
    r, s = rest @ residual, rest @ signatures

    def density_of(*sizes):
        return np.exp(s.T @ r @ sizes - 0.5 * np.sum((s @ sizes) ** 2))

    return density_of


def density(size, one_sided):
    """Nine in ten sizes log-normal about the typical one, which is 1/1.2 prior deviations, the rest normal."""
    if one_sided and size < 0.0:
        return 0.0
    log_normal = stats.lognorm.pdf(abs(size), 0.5, scale=1.0 / 1.2) / 2.0
    return (0.9 * log_normal + 0.1 * stats.norm.pdf(size)) * (2.0 if one_sided else 1.0)


@pytest.mark.parametrize("i", range(6))
def test_evidence_of_an_effect_is_the_integral_over_its_sizes(system, i):
    """SciPy's quad over the size of the effect."""
    residual, nuisances, signatures = system
    singles, _ = EvidenceMatrix.from_residual(residual, nuisances, signatures, ONE_SIDED, np.zeros(6)).singles()
    data = likelihood(residual, nuisances, signatures[:, [i]])
    whole = integrate.quad(
        lambda c: density(c, ONE_SIDED[i]) * data(c), -6.0, 6.0, points=[0.0, 1.0, 2.0], limit=200, epsabs=0.0
    )[0]
    assert singles[i] == pytest.approx(2.0 * np.log(whole), abs=2e-3)


def test_evidence_of_pairs_is_the_integral_over_both_sizes(system):
    """But for what the two sizes have to do with each other, which matters where the data do not ask for a pair."""
    residual, nuisances, signatures = system
    pairs = EvidenceMatrix.from_residual(residual, nuisances, signatures, ONE_SIDED, np.zeros(6)).pairs()
    assert len(pairs.evidence) == 15
    grid = np.linspace(-4.0, 5.0, 901)
    prior = np.array([[density(c, one_sided) for c in grid] for one_sided in (False, True)])
    for i, j, evidence in zip(pairs.first, pairs.second, pairs.evidence, strict=True):
        rest = np.linalg.svd(nuisances)[0][:, 3:].T
        r, s = rest @ residual, rest @ signatures[:, [i, j]]
        u, v = np.meshgrid(grid, grid, indexing="ij")
        g = s.T @ s
        log = s[:, 0] @ r * u + s[:, 1] @ r * v - 0.5 * (g[0, 0] * u**2 + 2.0 * g[0, 1] * u * v + g[1, 1] * v**2)
        whole = prior[int(ONE_SIDED[i])] @ np.exp(log - log.max()) @ prior[int(ONE_SIDED[j])] * (grid[1] - grid[0]) ** 2
        exact = 2.0 * (np.log(whole) + log.max())
        assert (evidence > 0.0) == (exact > 0.0)
        if exact > 0.0:
            assert evidence == pytest.approx(exact, abs=0.1)


def test_an_effect_made_free_leaves_what_least_squares_leaves(system):
    """NumPy's lstsq."""
    residual, nuisances, signatures = system
    gram = EvidenceMatrix.from_residual(residual, nuisances, signatures, np.zeros(6, dtype=bool), np.zeros(6)).without(
        np.array([1, 4])
    )
    both = np.hstack([nuisances, signatures[:, [1, 4]]])
    left = residual - both @ np.linalg.lstsq(both, residual, rcond=None)[0]
    assert gram.left == pytest.approx(left @ left, rel=1e-9)
    for i in (0, 2, 3, 5):
        column = signatures[:, i] - both @ np.linalg.lstsq(both, signatures[:, i], rcond=None)[0]
        assert gram.scores()[i] == pytest.approx(column @ left / np.linalg.norm(column), rel=1e-7)


@pytest.mark.parametrize("one_sided", [False, True])
@pytest.mark.parametrize("mean", [-2.0, -0.3, 0.0, 0.2, 1.5, 4.0])
@pytest.mark.parametrize("sigmas", [0.0, 1.0, 9.0])
def test_the_gain_of_typical_sizes_is_the_ratio_of_two_integrals(mean, sigmas, one_sided):
    """The data say ``mean`` with so many ``sigmas`` to the prior deviation; 0 says nothing, nothing is gained."""

    def integral(prior):
        at = (0.0, 0.5, 1.0, mean, (info := sigmas**2) * mean / (1.0 + info))
        return integrate.quad(
            lambda c: prior(c) * np.exp(-0.5 * info * (c - mean) ** 2), -8.0, 8.0, points=sorted(at), limit=400
        )[0]

    exact = 2.0 * np.log(integral(lambda c: density(c, one_sided)) / integral(stats.norm.pdf))
    info = sigmas**2
    size, std = info * mean / (1.0 + info), 1.0 / np.sqrt(1.0 + info)
    assert size_factor(np.array([size]), np.array([std]), np.array([one_sided]))[0] == pytest.approx(exact, abs=5e-3)


def test_the_score_exceeds_its_quantile_as_often_as_asked():
    """Monte Carlo: 2000 sets of pure noise."""
    rng = np.random.default_rng(2)
    signatures = rng.standard_normal((60, 4)) @ rng.standard_normal((4, 30))  # far more effects than directions
    nuisances, alpha, n = rng.standard_normal((60, 3)), 0.05, 2000
    one_sided = np.arange(30) % 3 == 0
    quantile, alarms = None, 0
    for _ in range(n):
        noise = rng.standard_normal(60)
        gram = EvidenceMatrix.from_residual(noise, nuisances, signatures, one_sided, np.zeros(30))
        quantile = null_quantile(gram, np.inf, alpha, 0) if quantile is None else quantile
        scores = gram.scores()
        alarms += np.where(one_sided, scores, np.abs(scores)).max() > quantile
    assert abs(alarms - alpha * n) < 4.0 * np.sqrt(n * alpha * (1.0 - alpha))


def test_the_gates_say_how_rare_their_statistic_is():
    """Student's t by SciPy."""
    rng = np.random.default_rng(3)
    signature = rng.standard_normal((50, 1))
    gram = EvidenceMatrix.from_residual(
        rng.standard_normal(50), np.ones((50, 1)), 9.0 * signature, np.array([False]), np.zeros(1)
    )
    gate = score_test(gram, 20.0, 0, 0.01, 0)
    exact = 2.0 * stats.t.sf(gate.statistic, 20.0)
    assert gate.p == pytest.approx(exact, abs=4.0 * np.sqrt(exact / 10_000) + 1e-3)
    nuisances, smooth, residual = rng.standard_normal((50, 3)), rng.standard_normal((50, 5)), rng.standard_normal(50)
    found = trend_test(residual, nuisances, [smooth], [37.0], 0, 0.01)
    left = [
        np.sum((residual - m @ np.linalg.lstsq(m, residual, rcond=None)[0]) ** 2)
        for m in (nuisances, np.hstack([nuisances, smooth]))
    ]
    assert found.statistic == pytest.approx((left[0] - left[1]) / 5, rel=1e-9)
    assert found.p == pytest.approx(stats.f.sf(found.statistic, 5, 37.0), rel=1e-9)


def test_a_memory_half_known_costs_only_what_changes_slowly():
    """Exact: a constant and the last of all waves, up and down from row to row, have slowness 1 and -1."""
    chain = RowOrder.from_runs(np.zeros(40, dtype=int), np.arange(40))
    constant, up_and_down = (np.repeat(column, 3)[:, None] for column in (np.ones(40), (-1.0) ** np.arange(40)))
    assert chain.slowness(constant) == pytest.approx(39 / 40)
    assert chain.slowness(up_and_down) == pytest.approx(-39 / 40)
    assert chain.slowness(np.hstack([constant, up_and_down])) == pytest.approx(0.0, abs=1e-12)
    cleaned = NoiseFit(np.zeros((40, 3)), np.ones(3), 0.3, 0.1, 0.0, 100.0, np.zeros(40, dtype=bool))
    assert cleaned.trusted_dof(0.0) == pytest.approx(100.0)
    slow = 2.0 * (0.1 / 0.91) ** 2 * 0.09 / (0.09 + 0.01)
    assert cleaned.trusted_dof() == pytest.approx(1.0 / (0.01 + slow))


def test_innovations_with_missing_rows_are_independent():
    """Theory of AR(1): the whitened covariance is the identity."""
    rows = np.array([0, 1, 2, 5, 6, 9, 10, 11])
    chain = RowOrder.from_runs(np.array([0] * 7 + [1] * 5), rows)
    covariance = 0.6 ** np.abs(rows[:, None] - rows)
    covariance[:5, 5:] = covariance[5:, :5] = 0.0
    turned = chain.innovations(chain.innovations(covariance, 0.6).T.copy(), 0.6)
    np.testing.assert_allclose(turned, np.eye(8), atol=1e-14)


def noise_of(rng, n, memory=0.0):
    noise = rng.standard_normal((n, 3))
    for i in range(1, n):
        noise[i] = memory * noise[i - 1] + np.sqrt(1.0 - memory**2) * noise[i]
    return noise


def test_a_channel_of_few_readings_leans_on_the_others():
    """Stein: of noise that is alike in all channels, what five readings say is nearer the truth with the others' help.

    The square of the logarithm of a scale from five readings is 0.13 in the mean, see the digamma function.
    """
    rng, good = np.random.default_rng(0), np.ones((60, 3), dtype=bool)
    good[5:, 2] = False
    found = [_scale(rng.normal(size=(60, 3)), good, np.zeros((180, 0)), np.zeros(3, dtype=bool))[0] for _ in range(400)]
    alone = 0.25 * (special.polygamma(1, 2.5) + (special.digamma(2.5) - np.log(2.5)) ** 2)
    assert (np.log(np.array(found)[:, 2]) ** 2).mean() < 0.5 * alone


@pytest.mark.parametrize("memory", [0.0, 0.3])
def test_scale_and_memory_of_noise_are_found(memory):
    """Monte Carlo: known scale and correlation beside 40 free columns."""
    rng = np.random.default_rng(4)
    n, sets = 80, 60
    chain, found = RowOrder.from_runs(np.zeros(n, dtype=np.int64), np.arange(n)), []
    for _ in range(sets):
        basis = rng.standard_normal((n, 3, 40))
        noise = noise_of(rng, n, memory) + basis @ rng.standard_normal(40)
        found.append(clean(noise, np.ones((n, 3), dtype=bool), basis, chain, ALL))
    scale = np.mean([entry.scale for entry in found], axis=0)
    np.testing.assert_allclose(scale, 1.0, atol=0.04)
    lag = np.array([entry.memory for entry in found])
    assert abs(lag.mean() - memory) < (0.06 if memory == 0.0 else 0.05)
    assert not any(entry.outlier.any() for entry in found)


def test_an_outlier_is_found_also_at_high_leverage():
    """By hand: one reading moved by 30 sigma where the leverage is 90 %."""
    rng = np.random.default_rng(5)
    n = 60
    basis = rng.standard_normal((n, 3, 20))
    basis[7] *= 5.0  # 90 % of what is measured there is fitted there
    noise = noise_of(rng, n)
    noise[7] += 30.0
    found = clean(
        noise, np.ones((n, 3), dtype=bool), basis, RowOrder.from_runs(np.zeros(n, dtype=np.int64), np.arange(n)), ALL
    )
    assert np.flatnonzero(found.outlier).tolist() == [7]
    assert np.all(found.residual[7] == 0.0)


def test_removing_a_row_takes_off_what_a_fit_without_it_does():
    """NumPy's lstsq without the row."""
    rng = np.random.default_rng(6)
    columns, residual = rng.standard_normal((30, 4)), rng.standard_normal((10, 3))

    def left(rows):
        keep = np.repeat(rows, 3)
        off = (
            residual.ravel()[keep]
            - columns[keep] @ np.linalg.lstsq(columns[keep], residual.ravel()[keep], rcond=None)[0]
        )
        return off @ off

    every = np.ones(10, dtype=bool)
    brute = [left(every) - left(np.arange(10) != i) for i in range(10)]
    np.testing.assert_allclose(removal(residual, orthonormal(columns)), brute, rtol=5e-3)


def test_heavy_tails_are_seen_and_cost_less_than_their_variance():
    """Monte Carlo: Student's t with 3 degrees of freedom."""
    rng = np.random.default_rng(7)
    n = 400
    basis, chain = rng.standard_normal((n, 3, 10)), RowOrder.from_runs(np.zeros(n, dtype=np.int64), np.arange(n))
    noise = rng.standard_t(3.0, (n, 3)) / np.sqrt(3.0)
    found = clean(noise, np.ones((n, 3), dtype=bool), basis, chain, ALL)
    assert found.tail >= 0.2
    assert np.all(found.scale < 0.85)  # the bound of Cramer and Rao is (1/2)^1/2


def test_the_holdout_takes_a_quarter_with_all_repeats():
    """Counting: 40 loads, three times each."""
    load = np.random.default_rng(8).permutation(np.repeat(np.arange(40), 3))
    columns = {"lam_l_N": 4.0 * load, "lam_r_N": 160.0 - 4.0 * load, "pose_id": [f"p{i}" for i in load]}
    data = Measurements.from_columns({**columns, "x_m": 0.1 + 0.0 * load})
    locked = lock([data], 3)
    assert locked.sum() == 30
    assert all(locked[load == i].all() or not locked[load == i].any() for i in range(40))
    assert not np.array_equal(locked, lock([data], 4))
    assert not lock([data.select(np.arange(12))], 0).any()


def test_priors_are_in_standard_deviations():
    """By hand: a logarithmic, a linear and no prior."""
    prior = Priors(np.array([3.0, 2.0, 7.0]), np.array([0.5, 0.1, np.inf]), np.array([True, False, False]))
    off, slope = prior.rows(np.array([6.0, 2.2, 1.0]))
    np.testing.assert_allclose(off, [np.log(2.0) / 0.5, 2.0])
    np.testing.assert_allclose(slope, [[1.0 / 3.0, 0.0, 0.0], [0.0, 10.0, 0.0]])


def test_a_local_disagreement_is_found_where_it_is():
    """Monte Carlo: 200 sets of pure noise, and a known region."""
    rng = np.random.default_rng(8)
    lam = np.array([(a, b) for a in np.linspace(0.0, 160.0, 9) for b in np.linspace(0.0, 160.0, 9)])
    count = np.full(81, 3.0)
    chances = np.array([scan(lam, rng.chisquare(3.0, 81), count, seed)[1] for seed in range(200)])
    for level in (0.05, 0.2):
        assert abs(np.mean(chances <= level) - level) < 3.0 * np.sqrt(level * (1.0 - level) / 200)
    true = lam[:, 0] - lam[:, 1] > 110.0
    scores = []
    for seed in range(20):
        squares = rng.chisquare(3.0, 81) + np.where(true, 60.0, 0.0)
        text, chance = scan(lam, squares, count, seed)
        assert chance <= 0.01
        name, sign, border, _ = text.rsplit(" ", 3)
        assert (name, sign) == ("lam_l - lam_r", ">")
        found = lam[:, 0] - lam[:, 1] > float(border)
        scores.append(2.0 * np.sum(found & true) / (np.sum(found) + np.sum(true)))
    assert np.mean(scores) > 0.95
