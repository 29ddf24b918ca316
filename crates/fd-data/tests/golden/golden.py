"""Writes the reference values of `golden.rs` from scikit-learn 1.9.1, numpy 2.4.6 and scipy 1.17.1:

    python golden.py

`log.csv` is a process of two states with three outputs and one input; `expected.csv` holds names and numbers.
"""

import csv

import numpy as np
from scipy import linalg, stats
from sklearn.cross_decomposition import CCA
from sklearn.decomposition import PCA

rng = np.random.default_rng(7)
n = 240
a = np.array([[0.9, 0.1], [-0.1, 0.7]])
b = np.array([0.5, 0.2])
c = np.array([[1.0, 0.0], [0.4, 1.0], [1.0, -1.0]])
x, rows = np.zeros(2), []
for k in range(n):
    u = np.sin(0.13 * k) + 0.5 * rng.standard_normal()
    y = c @ x + 0.1 * rng.standard_normal(3) + np.array([3.0, -1.0, 20.0])
    rows.append([u, *y])
    x = a @ x + b * u + 0.05 * rng.standard_normal(2)
z = np.round(np.array(rows), 6)
with open("log.csv", "w", newline="") as file:
    csv.writer(file).writerows(z)

expected = {}


def put(name, values):
    expected[name] = np.atleast_1d(values)


def windows(data, lags):
    return np.hstack([data[i : len(data) - lags + i] for i in range(lags + 1)])


standard = (z - z.mean(0)) / z.std(0, ddof=1)
for name, lags, components in (("pca", 0, 2), ("dpca", 2, 5)):
    w = windows(standard, lags)
    fit = PCA(n_components=components, svd_solver="full").fit(w)
    score = fit.transform(w)
    t2 = (score**2 / fit.explained_variance_).sum(1)
    q = ((w - fit.inverse_transform(score)) ** 2).sum(1)
    put(name + ".eigenvalues", PCA(svd_solver="full").fit(w).explained_variance_)
    put(name + ".t2", t2[:20])
    put(name + ".q", q[:20])
    m = len(w)
    put(name + ".t2_limit", components * (m**2 - 1) / (m * (m - components)) * stats.f.ppf(0.99, components, m - components))
    left = PCA(svd_solver="full").fit(w).explained_variance_[components:]
    t1, t2_, t3 = left.sum(), (left**2).sum(), (left**3).sum()
    h = 1 - 2 * t1 * t3 / (3 * t2_**2)
    inner = stats.norm.ppf(0.99) * np.sqrt(2 * t2_ * h**2) / t1 + 1 + t2_ * h * (h - 1) / t1**2
    put(name + ".q_limit", t1 * inner ** (1 / h))

past, future = 3, 2
w = windows(standard, past + future - 1)
p, f = w[:, : 4 * past], w[:, 4 * past :].reshape(len(w), future, 4)[:, :, 1:].reshape(len(w), -1)
# By way of orthonormal bases, not of covariances (Bjorck and Golub 1973).
put("cva.correlations", np.linalg.svd(linalg.orth(p - p.mean(0)).T @ linalg.orth(f - f.mean(0)), compute_uv=False))
cca = CCA(n_components=1, max_iter=100000, tol=1e-14).fit(p, f)
s, t = cca.transform(p, f)
put("cva.first_by_cca", np.corrcoef(s[:, 0], t[:, 0])[0, 1])
basis = linalg.orth(p - p.mean(0))
u = np.linalg.svd(basis.T @ linalg.orth(f - f.mean(0)))[0]
variates = basis @ u * np.sqrt(len(w) - 1)
put("cva.t2", (variates[:20, :2] ** 2).sum(1))
put("cva.rest", (variates[:20, 2:] ** 2).sum(1))

with open("expected.csv", "w", newline="") as file:
    rows = csv.writer(file)
    for name, values in expected.items():
        rows.writerow([name, *(f"{value:.15g}" for value in values)])
