//! The engines of a scenario: their runs, and the faults laid on them.

use std::cell::LazyCell;

use fd_jetengine::engine17::HealthParameter;
use fd_model::{
    Record,
    fault::{ChannelRef, FaultProfile, FaultSpec, Site},
};

use super::{
    config::CompareConfig,
    error::CompareError,
    fault::FaultKind,
    plants::{Ask, Plants, Runs},
    scenario::{Present, Scenario},
};
use crate::engine::{Benchmark, Case, Draw, EngineStudyError, Reality};

/// Perturbed engines of one kind.
pub(super) struct EnginePlants<'a> {
    config: &'a CompareConfig,
    kinds: Vec<FaultKind>,
    benchmark: Benchmark,
    present: Option<&'a Present>,
}

impl<'a> EnginePlants<'a> {
    pub(super) fn new(
        config: &'a CompareConfig,
        scenario: &'a Scenario,
    ) -> Result<Self, CompareError> {
        let wrong = |error| CompareError::Scenario {
            scenario: scenario.name.clone(),
            error: Box::new(error),
        };
        let benchmark = Benchmark::new(config.engine(scenario)).map_err(wrong)?;
        let kinds = config.faults.kinds(benchmark.is_nonlinear());
        let plants = Self { config, kinds, benchmark, present: scenario.present.as_ref() };
        let sites = plants.kinds.iter().map(|kind| &kind.site);
        for site in sites.chain(plants.present.map(|p| &p.site)) {
            plants.check(site, &scenario.name)?;
        }
        Ok(plants)
    }

    fn check(&self, site: &Site, scenario: &str) -> Result<(), CompareError> {
        let unknown = |expected| {
            Err(CompareError::Setting {
                setting: format!("fault site in scenario `{scenario}`"),
                expected,
                found: site.to_string(),
            })
        };
        match site {
            Site::Sensor(sensor) if self.output(sensor).is_none() => {
                unknown("an output of the engine")
            }
            Site::Component(part) if health(part).is_none() || !self.benchmark.is_nonlinear() => {
                unknown("a health parameter of a nonlinear engine, such as `hpc_efficiency`")
            }
            Site::Sensor(_) | Site::Component(_) => Ok(()),
            _ => unknown("a sensor or a component"),
        }
    }

    fn output(&self, sensor: &ChannelRef) -> Option<usize> {
        let outputs = self.benchmark.outputs();
        match sensor {
            ChannelRef::Index(index) => (*index < outputs.len()).then_some(*index),
            ChannelRef::Name(name) => outputs.iter().position(|channel| channel.name == *name),
        }
    }

    fn all(&self, ask: Ask) -> Result<Runs, EngineStudyError> {
        let Ask { seed, fresh_runs, tested } = ask;
        let mut case = self.benchmark.case(seed)?;
        let worn = self.worn(&case)?;
        let constant = self.constant_fault();
        let early = self.present.is_some_and(|present| present.while_learning);
        let training = self.benchmark.draw_training(&mut case)?;
        let fresh = |case: &mut Case, count: u64| -> Result<Vec<Draw>, EngineStudyError> {
            (0..count).map(|_| self.benchmark.draw_fresh(case)).collect()
        };
        let engines = self.config.engines;
        let calibration = fresh(&mut case, engines.calibration_runs)?;
        let with_faults = if tested { engines.fault_runs } else { 0 };
        let draws = fresh(&mut case, fresh_runs)?;
        let new = (&case.training, &case.moved);
        let (learned, moved) = worn.as_ref().map_or(new, |(learned, moved)| (learned, moved));
        // The engine and what its sensors do, while learning and afterwards.
        let before: (&Reality, &[FaultSpec]) =
            if early { (learned, &constant) } else { (&case.training, &[]) };
        let after: (&Reality, &[FaultSpec]) = if tested { (moved, &constant) } else { before };
        let run = |at: (&Reality, &[FaultSpec]), draw: &Draw| self.benchmark.run(at.0, draw, at.1);
        let healthy: Vec<Record> =
            draws.iter().map(|draw| run(after, draw)).collect::<Result<_, _>>()?;
        let faulty = (0..).zip(draws.iter().zip(&healthy)).take_while(|(i, _)| *i < with_faults);
        let faulty = faulty.map(|(i, (draw, healthy))| self.faulty(after, draw, healthy, i));
        let faulty = faulty.collect::<Result<_, _>>()?;
        Ok(Runs {
            training: run(before, &training)?,
            calibration: calibration.iter().map(|d| run(before, d)).collect::<Result<_, _>>()?,
            model: case.model.clone(),
            scaling: case.plant().scaling(),
            healthy,
            faulty,
            unseen: self.unseen(),
        })
    }

    /// Every run begins with the engine at rest; a residual does only if its model rests there too, as that of a
    /// nonlinear model of another engine does not.
    fn unseen(&self) -> usize {
        let settle = self.config.settle_s.unwrap_or(0.0);
        self.config.samples(settle).min(self.config.fault_start())
    }

    /// One run with each fault in each size.
    fn faulty(
        &self,
        (plant, constant): (&Reality, &[FaultSpec]),
        draw: &Draw,
        healthy: &Record,
        run: u64,
    ) -> Result<Vec<Vec<Record>>, EngineStudyError> {
        let faults = &self.config.faults;
        let fork = LazyCell::new(|| Benchmark::fork(plant, draw, self.config.fault_start()));
        let one = |kind: &FaultKind, s: usize| -> Result<Record, EngineStudyError> {
            // Both signs in turn.
            let sign = if (run + s as u64).is_multiple_of(2) { 1.0 } else { -1.0 };
            let size = sign * kind.sizes[s];
            let fault = faults.spec(kind, size, self.config.duration_s());
            if matches!(kind.site, Site::Sensor(_)) {
                // What the sensor says changes nothing in the engine.
                let mut record = healthy.clone();
                fault.apply_to_record(&mut record).map_err(fd_model::SimulationError::from)?;
                return Ok(record);
            }
            self.benchmark.run_on(plant, (draw, healthy), &fork, (constant, fault))
        };
        let sizes = |kind: &FaultKind| (0..kind.sizes.len()).map(|s| one(kind, s)).collect();
        self.kinds.iter().map(sizes).collect()
    }

    /// The engine with the component that has worn before anybody looked.
    fn worn(&self, case: &Case) -> Result<Option<(Reality, Reality)>, EngineStudyError> {
        match self.present {
            Some(Present { site: Site::Component(part), size, .. }) => match health(part) {
                Some(parameter) => self.benchmark.worn(case, parameter, *size),
                None => Ok(None),
            },
            _ => Ok(None),
        }
    }

    /// The sensor that has always been wrong.
    fn constant_fault(&self) -> Vec<FaultSpec> {
        match self.present {
            Some(Present { site: site @ Site::Sensor(_), size, .. }) => {
                vec![FaultSpec::add(site.clone(), 0.0, FaultProfile::abrupt(*size))]
            }
            _ => Vec::new(),
        }
    }
}

impl Plants for EnginePlants<'_> {
    fn kinds(&self) -> &[FaultKind] {
        &self.kinds
    }

    fn outputs(&self) -> Vec<String> {
        self.benchmark.outputs().into_iter().map(|channel| channel.name).collect()
    }

    fn runs(&self, ask: Ask) -> Result<Runs, CompareError> {
        Ok(self.all(ask)?)
    }
}

fn health(part: &ChannelRef) -> Option<HealthParameter> {
    match part {
        ChannelRef::Index(index) => HealthParameter::ALL.get(*index).copied(),
        ChannelRef::Name(name) => HealthParameter::ALL.into_iter().find(|p| p.name() == name),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is simulated from the start of a fault on is what a whole run with that fault shows, also on a worn
    /// engine with lags and a sensor that has always been wrong.
    #[test]
    fn a_fork_is_the_whole_run() {
        let mut config = CompareConfig::default();
        config.faults.component_sizes.count = 2;
        config.scenarios.retain(|scenario| scenario.name == "all-lags");
        let present = |site, while_learning| Some(Present { site, size: 0.01, while_learning });
        for present in
            [present(Site::component("hpc_flow"), false), present(Site::sensor("T_7"), true)]
        {
            config.scenarios[0].present = present;
            let plants = EnginePlants::new(&config, &config.scenarios[0]).unwrap();
            let mut case = plants.benchmark.case(3).unwrap();
            let worn = plants.worn(&case).unwrap();
            let draw = plants.benchmark.draw_fresh(&mut case).unwrap();
            let plant = worn.as_ref().map_or(&case.moved, |(_, moved)| moved);
            let constant = plants.constant_fault();
            let healthy = plants.benchmark.run(plant, &draw, &constant).unwrap();
            let records = plants.faulty((plant, &constant), &draw, &healthy, 0).unwrap();
            let mut components = 0;
            for (kind, records) in plants.kinds.iter().zip(records) {
                components += usize::from(!matches!(kind.site, Site::Sensor(_)));
                for (s, forked) in records.iter().enumerate() {
                    let sign = if s.is_multiple_of(2) { 1.0 } else { -1.0 };
                    let fault = config.faults.spec(kind, sign * kind.sizes[s], config.duration_s());
                    let all: Vec<FaultSpec> = constant.iter().cloned().chain([fault]).collect();
                    let whole = plants.benchmark.run(plant, &draw, &all).unwrap();
                    for k in 0..whole.len() {
                        for (a, b) in forked.y(k).iter().zip(whole.y(k)) {
                            // Until the fault nothing differs. After it, times from the fork and from the
                            // beginning round differently, by some 1e-15 s, and with them the size of a
                            // growing fault, by 1e-17; readings are of size 1 and the engine is stable.
                            let most = if k < config.fault_start() { 0.0 } else { 1e-13 };
                            assert!((a - b).abs() <= most, "{} sample {k}: {a} {b}", kind.name());
                        }
                    }
                    let (last, at_rest) = (whole.len() - 1, healthy.y(healthy.len() - 1));
                    let moved =
                        forked.y(last).iter().zip(at_rest).any(|(a, b)| (a - b).abs() > 1e-6);
                    assert!(moved, "{} does nothing", kind.name());
                }
            }
            assert_eq!(components, 2);
        }
    }
}
