"""Weights of the couplings of two robots, learned by torch through the closed loop: PYTHONPATH=... python3 FILE

The loss is the mean squared distance of the observer from 1.5 m behind its target. Without torch the program ends with a
sentence.
"""

import sys

import numpy as np
import sightline as sl

try:
    import torch
except ImportError:
    print("weights_by_torch: skipped, torch is not installed")
    sys.exit(0)

START = [-2.0, -0.3, 0.6, 1, 0, 0, 0, 0, 0, 0.5, 1, 0, 0, 0]
KEYS = ["couple[0].weight", "couple[1].weight", "couple[2].weight"]


def team_of(weights):
    team = sl.Team()
    observer = team.add(sl.multirotor(), Q=[0, 0, 0, 0, 0, 0.7, 0.7])
    target = team.add(
        sl.multirotor(), Q=[1.5, 1.5, 1.6, 1, 1, 0, 0], x_ref=sl.circle(centre=[0, 0, 1], radius=0.5, rate=0.3)
    )
    potentials = [
        sl.sensor_cone(alpha=0.5, kappa_G=0.01, kappa_A=2),
        sl.keep_out(d_min=1, kappa_H=4.5, kappa_G=0.001, kappa_A=3),
        sl.cohesion(d_max=2, kappa_H=1.5, kappa_G=0.001, kappa_A=3),
    ]
    for weight, potential in zip(weights, potentials):
        team.couple(weight * potential, between=(observer, target), felt_by=observer)
    return team


class Flight(torch.autograd.Function):
    """States (K+1 x nx) of a flight under weights."""

    @staticmethod
    def forward(ctx, weights, periods):
        ctx.loop = sl.LoopGradient(team_of(weights.tolist()), T=1.0, N=20, dt=0.05)
        return torch.from_numpy(ctx.loop.fly(START, periods)[0])

    @staticmethod
    def backward(ctx, by_x):
        slopes = ctx.loop.differentiate(np.ascontiguousarray(by_x.numpy())).parameters
        return torch.tensor([slopes[key] for key in KEYS], dtype=torch.float64), None


def loss_of(states):
    distance = torch.linalg.norm(states[:, 0:3] - states[:, 7:10], dim=1)
    return ((distance - 1.5) ** 2).mean()


logarithms = torch.log(torch.full((3,), 0.4, dtype=torch.float64)).requires_grad_()
optimizer = torch.optim.Adam([logarithms], lr=0.2)
for step in range(10):
    loss = loss_of(Flight.apply(torch.exp(logarithms), 100))
    print(f"step {step}: loss {loss.item():.4f} m^2, weights {torch.exp(logarithms).detach().numpy().round(3)}")
    optimizer.zero_grad()
    loss.backward()
    optimizer.step()
