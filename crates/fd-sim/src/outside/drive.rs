//! Inputs that a simulator is checked with.

/// What a simulator is driven with while it is checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Drive {
    /// Samples of a run.
    pub samples: usize,
    /// Inputs of all samples, row by row.
    pub u: Vec<f64>,
    /// Size of each input: small changes are made in parts of it.
    pub sizes: Vec<f64>,
    /// Whether the simulator is asked for single steps, too.
    pub by_steps: bool,
}

impl Drive {
    /// Steps of random height for each input, held for 10 to 40 samples, from a generator of Lehmer's kind (S. K. Park,
    /// K. W. Miller, "Random number generators: good ones are hard to find", CACM 31 (1988) 1192).
    #[must_use]
    pub fn random(samples: usize, inputs: usize, amplitude: f64) -> Self {
        const MODULUS: u64 = 2_147_483_647;
        let mut seed = 4711_u64;
        let mut next = |low: f64, high: f64| {
            seed = seed * 48_271 % MODULUS;
            low + (high - low) * seed as f64 / MODULUS as f64
        };
        let mut u = vec![0.0; samples * inputs];
        for i in 0..inputs {
            let (mut level, mut until) = (0.0, 0.0);
            for k in 0..samples {
                if until <= k as f64 {
                    level = amplitude * next(-1.0, 1.0);
                    until = k as f64 + next(10.0, 40.0);
                }
                u[k * inputs + i] = level;
            }
        }
        Self { samples, u, sizes: vec![amplitude; inputs], by_steps: true }
    }

    /// The inputs of a log, row by row.
    #[must_use]
    pub fn logged(u: Vec<f64>, samples: usize) -> Self {
        let inputs = u.len() / samples.max(1);
        let size = |i: usize| {
            let values = u.iter().skip(i).step_by(inputs);
            let size = values.fold(0.0_f64, |size, u| size.max(u.abs()));
            if size == 0.0 { 1.0 } else { size }
        };
        let sizes = (0..inputs).map(size).collect();
        Self { samples, u, sizes, by_steps: true }
    }
}
