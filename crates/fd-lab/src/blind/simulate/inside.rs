//! What happens inside the plant during an integration step.

use super::{Injected, Run};
use crate::blind::laws::{Mechanism, Site};

impl Run<'_> {
    fn rates(&self, x: &[f64], f: &[f64]) -> Vec<f64> {
        let mut dx = vec![0.0; x.len()];
        self.physics.rates(x, &self.u, f, &mut dx);
        for (inner, change) in self.inner.iter().zip(&self.changes).filter(|(_, c)| **c != 0.0) {
            (inner.add)(&self.parameters, *change, &mut dx);
        }
        dx
    }

    /// What moves at a site: the velocity, or else the position.
    fn moving(&self, x: &[f64], site: usize) -> f64 {
        let [position, velocity] = self.physics.motion(x, site);
        velocity.or(position).unwrap_or(0.0)
    }

    pub(super) fn compliances(&mut self) {
        let mut f = vec![0.0; self.held.len()];
        let free = self.rates(&self.x, &f);
        for site in 0..f.len() {
            // Forces enter linearly.
            f[site] = 1.0;
            let pushed = self.rates(&self.x, &f);
            f[site] = 0.0;
            let difference: Vec<f64> = pushed.iter().zip(&free).map(|(a, b)| a - b).collect();
            self.compliance[site] = self.moving(&difference, site);
        }
    }

    pub(super) fn sites<'b>(&self, x: &'b [f64], f: &[f64]) -> Vec<Site<'b>> {
        let dx = self.rates(x, f);
        let site = |i: usize| self.site(x, i, self.moving(&dx, i));
        (0..self.held.len()).map(site).collect()
    }

    fn site<'b>(&self, x: &'b [f64], i: usize, a: f64) -> Site<'b> {
        let [position, velocity] = self.physics.motion(x, i);
        let (position, velocity) = (position.unwrap_or(f64::NAN), velocity.unwrap_or(f64::NAN));
        Site { x: position, v: velocity, a, c: self.compliance[i], t: self.t, states: x }
    }

    /// Forces of all laws at a place, and rates of their states.
    fn forces(&self, x: &[f64], z: &[f64], dz: &mut [f64]) -> Vec<f64> {
        let mut f = self.held.clone();
        for wants_acceleration in [false, true] {
            let mut from = 0;
            for injected in &self.injected {
                let Mechanism::Force { states, accelerated, force, rates } = &injected.mechanism
                else {
                    continue;
                };
                let own = from..from + states;
                from += states;
                if *accelerated != wants_acceleration {
                    continue;
                }
                let i = injected.index;
                let a = if *accelerated { self.moving(&self.rates(x, &f), i) } else { 0.0 };
                let site = self.site(x, i, a);
                rates(&site, &z[own.clone()], &mut dz[own.clone()]);
                f[i] += force(&site, &z[own]);
            }
        }
        f
    }

    fn has_forces(&self) -> bool {
        let inside = |i: &Injected| {
            matches!(
                i.mechanism,
                Mechanism::Force { .. }
                    | Mechanism::HeldForce(_)
                    | Mechanism::Stick(_)
                    | Mechanism::Wall { .. }
            )
        };
        self.injected.iter().any(inside)
    }

    pub(super) fn integrate(&mut self) {
        let h = self.bench.h;
        if self.has_forces() {
            self.compliances();
            self.hold(h);
        }
        let (nx, nz) = (self.x.len(), self.z.len());
        let slope = |run: &Self, s: &[f64]| {
            let mut d = vec![0.0; nz];
            let f = run.forces(&s[..nx], &s[nx..], &mut d);
            let mut rates = run.rates(&s[..nx], &f);
            rates.extend(d);
            rates
        };
        let s: Vec<f64> = self.x.iter().chain(&self.z).copied().collect();
        let moved =
            |k: &[f64], h: f64| -> Vec<f64> { s.iter().zip(k).map(|(s, k)| s + h * k).collect() };
        let begun = self.t;
        let k_1 = slope(self, &s);
        self.t = begun + 0.5 * h;
        let k_2 = slope(self, &moved(&k_1, 0.5 * h));
        let k_3 = slope(self, &moved(&k_2, 0.5 * h));
        self.t = begun + h;
        let k_4 = slope(self, &moved(&k_3, h));
        for i in 0..nx + nz {
            let step = h / 6.0 * (k_1[i] + 2.0 * k_2[i] + 2.0 * k_3[i] + k_4[i]);
            if i < nx {
                self.x[i] += step;
            } else {
                self.z[i - nx] += step;
            }
        }
        self.bound();
    }

    /// Forces that are constant during a step.
    fn hold(&mut self, h: f64) {
        self.held.fill(0.0);
        let mut injected = std::mem::take(&mut self.injected);
        for one in &mut injected {
            let i = one.index;
            if let Mechanism::HeldForce(law) = &mut one.mechanism {
                let site = self.site(&self.x, i, 0.0);
                self.held[i] += law(&site, h);
            }
        }
        self.injected = injected;
        // Friction last: it holds against everything else.
        let mut dz = vec![0.0; self.z.len()];
        let f = self.forces(&self.x, &self.z, &mut dz);
        let rates = self.rates(&self.x, &f);
        let mut injected = std::mem::take(&mut self.injected);
        for one in &mut injected {
            let i = one.index;
            if let Mechanism::Stick(law) = &mut one.mechanism {
                let site = self.site(&self.x, i, self.moving(&rates, i));
                // What would bring it to rest by the end of the step.
                let stop = -(site.a + site.v / h) / site.c;
                let [forward, backward] = law(&site, h);
                let positive = site.c > 0.0;
                let (low, high) =
                    if positive { (-forward, backward) } else { (-backward, forward) };
                self.held[i] += stop.clamp(low, high);
            }
        }
        self.injected = injected;
    }

    /// Stores that are full, and walls.
    fn bound(&mut self) {
        for place in 0..self.injected.len() {
            let injected = &self.injected[place];
            let i = injected.index;
            let entered = |i: usize| {
                let site = &self.bench.model.sites[i];
                let state = site.enters.first().map(|(name, _)| name.clone());
                state.and_then(|name| {
                    self.bench.model.states.iter().position(|state| state.name == name)
                })
            };
            match injected.mechanism {
                Mechanism::Brim { brim, share } => {
                    let (Some(from), Some(to)) = (entered(i), entered(injected.partner)) else {
                        continue;
                    };
                    let excess = (self.x[from] - brim).max(0.0);
                    self.x[from] -= excess;
                    if 0.0 < share && from != to {
                        self.x[to] += share * excess;
                    }
                }
                Mechanism::Wall { low, high, restitution } => {
                    let [Some(x), Some(v)] = self.physics.motion(&self.x, i) else { continue };
                    let is_out = (high < x && 0.0 < v) || (x < low && v < 0.0);
                    if is_out {
                        let mut f = vec![0.0; self.held.len()];
                        let free = self.rates(&self.x, &f);
                        f[i] = 1.0;
                        let pushed = self.rates(&self.x, &f);
                        let impulse = -(1.0 + restitution) * v / self.compliance[i];
                        for ((x, pushed), free) in self.x.iter_mut().zip(pushed).zip(free) {
                            *x += impulse * (pushed - free);
                        }
                    }
                }
                _ => {}
            }
        }
    }
}
