"""D-optimal shares in the paper's own form: maximise Σ_d log|det(T_d − S_d Z̄_dᵀ)| over the simplex.

With T = Σ w_q X̄_q, S = Σ w_q Ȳ_q, Z̄ = Σ w_q Z̄_q and Σ w_q = 1. Without mean removal the second term is absent;
under batchwise subtraction T = Σ w_q (X̄_q − Ȳ_q Z̄_qᵀ) and the second term is absent.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from .moments import Moments


@dataclass(frozen=True)
class Block:
    """One degree of freedom: X̄ (Q × p × p), Ȳ and Z̄ (Q × p; zero where no mean couples the maneuvers)."""

    x: np.ndarray
    y: np.ndarray
    z: np.ndarray


@dataclass(frozen=True)
class Design:
    """Optimal shares (Q), sensitivities g_q, their bound p, the gap max g_q − p, and how many starts agreed."""

    shares: np.ndarray
    sensitivities: np.ndarray
    dimension: int
    gap: float
    log_det: float
    log_det_equal: float
    starts: int
    agreeing: int


def blocks(moments: list[list[Moments]], removal: str) -> list[Block]:
    """The problem's data; `moments` by maneuver and degree of freedom."""
    out = []
    for degree in zip(*moments):
        x = np.array([m.batch() if removal == "batch" else m.x for m in degree])
        y, z = np.array([m.y for m in degree]), np.array([m.z for m in degree])
        keep = 1.0 if removal == "complete" else 0.0
        out.append(Block(x, keep * y, keep * z))
    return out


def criterion(problem: list[Block], w: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
    """Value, gradient (Q) and Hessian (Q × Q) of the criterion as a function of free w."""
    q = len(w)
    value, gradient, hessian = 0.0, np.zeros(q), np.zeros((q, q))
    for b in problem:
        s, z = w @ b.y, w @ b.z
        a = np.tensordot(w, b.x, 1) - np.outer(s, z)
        inverse = np.linalg.inv(a)
        # dA/dw_q = X̄_q − Ȳ_q Z̄ᵀ − S Z̄_qᵀ;  d²A/dw_q dw_l = −Ȳ_q Z̄_lᵀ − Ȳ_l Z̄_qᵀ
        first = b.x - b.y[:, :, None] * z[None, None, :] - s[None, :, None] * b.z[:, None, :]
        turned = inverse @ first
        crossed = b.z @ inverse @ b.y.T
        value += np.linalg.slogdet(a)[1]
        gradient += np.trace(turned, axis1=1, axis2=2)
        hessian -= np.einsum("qij,lji->ql", turned, turned) + crossed + crossed.T
    return value, gradient, hessian


def optimal(moments: list[list[Moments]], removal: str, starts: int = 12, seed: int = 7) -> Design:
    """The best of several starts, each polished to the accuracy of the arithmetic."""
    problem = blocks(moments, removal)
    q = len(moments)
    equal = np.full(q, 1.0 / q)
    rng = np.random.default_rng(seed)
    points = [equal] + [rng.dirichlet(np.ones(q)) for _ in range(starts - 1)]
    solutions = [_polish(problem, _slsqp(problem, point)) for point in points]
    values = [criterion(problem, w)[0] for w in solutions]
    best = int(np.argmax(values))
    w, top = solutions[best], values[best]
    g, dimension = sensitivities(problem, w, removal)
    return Design(
        shares=w,
        sensitivities=g,
        dimension=dimension,
        gap=float(np.max(g) - dimension),
        log_det=top,
        log_det_equal=criterion(problem, equal)[0],
        starts=starts,
        agreeing=int(np.sum(np.abs(np.array(values) - top) < 1e-9 * max(1.0, abs(top)))),
    )


def from_equal_shares(problem: list[Block]) -> np.ndarray:
    """Shares from one start, as SLSQP leaves them: quick, to about 1e-4, and not polished."""
    count = len(problem[0].x)
    return _slsqp(problem, np.full(count, 1.0 / count), ftol=1e-9)


def sensitivities(problem: list[Block], w: np.ndarray, removal: str) -> tuple[np.ndarray, int]:
    """g_q = Σ_d tr(M_d⁻¹ M_d,q) and p with Σ w_q g_q = p, through the Schur complement A = T − S Z̄ᵀ of M.

    Under complete subtraction tr(M⁻¹ M_q) = tr(A⁻¹ (X̄_q − Ȳ_q Z̄ᵀ − S Z̄_qᵀ + S Z̄ᵀ)) + 1.
    """
    lifted = removal == "complete"
    g, dimension = np.zeros(len(w)), 0
    for b in problem:
        s, z = w @ b.y, w @ b.z
        inverse = np.linalg.inv(np.tensordot(w, b.x, 1) - np.outer(s, z))
        centred = b.x - b.y[:, :, None] * z - s[:, None] * b.z[:, None, :] + np.outer(s, z)
        g += np.einsum("ij,qji->q", inverse, centred) + lifted
        dimension += b.x.shape[1] + lifted
    return g, dimension


def _slsqp(problem: list[Block], start: np.ndarray, ftol: float = 1e-15) -> np.ndarray:
    def negative(w: np.ndarray) -> tuple[float, np.ndarray]:
        value, gradient, _ = criterion(problem, w)
        return -value, -gradient

    found = minimize(
        negative,
        start,
        jac=True,
        method="SLSQP",
        bounds=[(0.0, 1.0)] * len(start),
        constraints={"type": "eq", "fun": lambda w: w.sum() - 1.0, "jac": np.ones_like},
        options={"ftol": ftol, "maxiter": 2000},
    )
    return np.maximum(found.x, 0.0) / np.maximum(found.x, 0.0).sum()


def _polish(problem: list[Block], w: np.ndarray) -> np.ndarray:
    """Newton's method on the first-order conditions over the maneuvers in use; others enter or leave as they must."""
    used = w > 1e-6
    for _ in range(50):
        w = _newton(problem, np.where(used, w, 0.0), used)
        if np.any(w < 0.0):
            used &= w > 0.0
            w = np.maximum(w, 0.0) / np.maximum(w, 0.0).sum()
            continue
        gradient = criterion(problem, w)[1]
        excess = np.where(used, -np.inf, gradient - w @ gradient)
        if excess.max() <= 1e-9:
            return w
        used[int(np.argmax(excess))] = True
    return w


def _newton(problem: list[Block], w: np.ndarray, used: np.ndarray) -> np.ndarray:
    n = int(used.sum())
    w, multiplier = w / w.sum(), 0.0
    for _ in range(60):
        _, gradient, hessian = criterion(problem, w)
        system = np.zeros((n + 1, n + 1))
        system[:n, :n] = hessian[np.ix_(used, used)]
        system[:n, n], system[n, :n] = -1.0, 1.0
        residual = np.append(gradient[used] - multiplier, w.sum() - 1.0)
        step = np.linalg.lstsq(system, -residual, rcond=None)[0]
        w[used] += step[:n]
        multiplier += step[n]
        if np.max(np.abs(step[:n])) < 1e-15:
            break
    return w
