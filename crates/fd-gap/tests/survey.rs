//! Development survey: how often diagnoses of drawn cases are right. Ignored; run by hand with
//! `SURVEY=single CASES=40 cargo test -p fd-gap --test survey -- --ignored --nocapture`.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a tool for development")]

mod bench_cases;

use std::time::Instant;

use bench_cases::example;
use fd_gap::{
    diagnose::{Case, Diagnosis, Settings, diagnose},
    effect::{
        Candidate, EverySite, Kind, Observation, ReplayScales, SiteRef, Suspects, library,
        map::mechanism,
    },
    model::Model,
    simulate::{EquationSimulator, Simulator},
};
use fd_model::{
    Record, SampleTime,
    signal::{ArNoise, WhiteNoise},
};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

const PLANTS: [&str; 8] = [
    "mass_spring_damper",
    "dc_drive",
    "dc_drive_closed_loop",
    "pendulum",
    "cart_pole",
    "two_mass_drive",
    "tanks",
    "two_input",
];

type Random = Xoshiro256PlusPlus;

/// Steps of random height within the range of each input.
fn excitation(model: &Model, samples: usize, random: &mut Random) -> Vec<f64> {
    let inputs = model.external_inputs();
    let columns: Vec<Vec<f64>> = inputs
        .iter()
        .map(|input| {
            let [low, high] = match input.name.as_str() {
                "speed_ref" => [-250.0, 250.0],
                "u" if model.name == "tanks" => [2.0, 8.0],
                "u" => [-20.0, 20.0],
                "hot" | "cold" => [0.3e-4, 2e-4],
                "tau" if model.name == "pendulum" => [-3.0, 3.0],
                "tau" => [-5.0, 5.0],
                _ => [-12.0, 12.0],
            };
            let mut u = Vec::new();
            while u.len() < samples {
                let level = random.random_range(low..high);
                u.extend(std::iter::repeat_n(level, random.random_range(8..60_usize)));
            }
            u
        })
        .collect();
    (0..samples).flat_map(|k| columns.iter().map(move |c| c[k]).collect::<Vec<_>>()).collect()
}

struct Drawn {
    model: Model,
    truths: Vec<Candidate>,
    record: Record,
    held_out: Record,
    scales: ReplayScales,
    /// Root mean square difference that the effects make, in sigma.
    size: f64,
}

fn set(model: &Model, values: &[(String, f64)]) -> Vec<f64> {
    let known = |name: &str| values.iter().find(|(n, _)| n == name).map(|(_, v)| *v);
    model.parameters.iter().map(|p| known(&p.name).unwrap_or(p.value)).collect()
}

fn draw(kind: &str, seed: u64) -> Option<Drawn> {
    let mut random = Random::seed_from_u64(seed);
    let model = example(PLANTS[random.random_range(0..PLANTS.len())]);
    let samples = 600;
    let ts = SampleTime::new(model.sample_time).unwrap();
    let u = [0, 1].map(|_| excitation(&model, samples, &mut random));
    let scales = ReplayScales::of(&model, ts, &u[0], samples).unwrap();
    let suspects = EverySite::new(library(), &model, scales.clone());
    let mut truths: Vec<Candidate> = Vec::new();
    let mut patched = model.clone();
    let mut values: Vec<(String, f64)> = Vec::new();
    let effects = match kind {
        "nogap" | "coloured" => 0,
        "two" => 2,
        _ => 1,
    };
    for _ in 0..effects {
        let offers: Vec<Candidate> = match truths.last() {
            None => suspects.alone(),
            Some(first) => suspects.beside(first),
        }
        .into_iter()
        .flatten()
        .filter(|c| c.family != "map" && (c.kind == Kind::Simulation) == (kind != "observed"))
        .filter(|c| truths.iter().all(|t| t.label != c.label))
        .collect();
        let labels: Vec<&str> = offers.iter().map(|c| c.label).collect();
        let label = {
            let mut unique = labels.clone();
            unique.dedup();
            unique[random.random_range(0..unique.len())]
        };
        let same: Vec<&Candidate> = offers.iter().filter(|c| c.label == label).collect();
        let chosen = same[random.random_range(0..same.len())].clone();
        let start = chosen.starts[random.random_range(0..chosen.starts.len())].clone();
        let factor = f64::exp(random.random_range(-0.7..1.2_f64));
        for (p, value) in chosen.parameters.iter().zip(&start) {
            let value =
                if p.is_strength { p.neutral + factor * (value - p.neutral) } else { *value };
            values.push((p.name.clone(), value.clamp(p.low, p.high)));
        }
        patched = chosen.model.clone();
        truths.push(chosen);
    }
    // Reality: other parameters, another start.
    for p in &model.parameters {
        let error = p.tolerance.min(0.03) * random.random_range(-1.0..1.0);
        values.push((p.name.clone(), p.value * (1.0 + error)));
    }
    let run = |model: &Model, u: &[f64], x0: &[f64]| -> Option<Vec<f64>> {
        let mut simulator = EquationSimulator::<f64>::new(model).ok()?.refined(4);
        let mut y = vec![0.0; samples * model.outputs.len()];
        Simulator::simulate(&mut simulator, &set(model, &values), x0, u, &mut y);
        y.iter().all(|v| v.is_finite()).then_some(y)
    };
    let mut logs = Vec::new();
    let mut size = 0.0;
    for u in &u {
        let moved: Vec<f64> = model
            .states
            .iter()
            .map(|s| s.initial + s.tolerance.unwrap_or(0.0) * random.random_range(-1.0..1.0))
            .collect();
        let start = |m: &Model| -> Vec<f64> {
            m.all_states().enumerate().map(|(i, s)| *moved.get(i).unwrap_or(&s.initial)).collect()
        };
        let mut y = run(&patched, u, &start(&patched))?;
        let plain = run(&model, u, &start(&model))?;
        let ny = model.outputs.len();
        for (c, output) in model.outputs.iter().enumerate() {
            let sigma = output.noise.unwrap();
            let squares: f64 =
                (0..samples).map(|k| (y[k * ny + c] - plain[k * ny + c]).powi(2)).sum();
            size = f64::max(size, (squares / samples as f64).sqrt() / sigma);
            let noise_seed = random.random();
            let mut noise = if kind == "coloured" || seed % 4 == 3 && kind == "single" {
                ArNoise::new(vec![0.8], sigma, noise_seed).values(samples).unwrap()
            } else {
                WhiteNoise::new(sigma, noise_seed).values(samples).unwrap()
            };
            let observed = truths.iter().find(|t| {
                t.kind != Kind::Simulation && t.site == SiteRef::Output(c, output.name.clone())
            });
            let strength = [1.5, 3.0, 6.0][usize::try_from(seed % 3).unwrap()];
            match observed.map(|t| t.kind) {
                Some(Kind::Observation(Observation::Noise)) => {
                    noise.iter_mut().for_each(|e| *e *= strength);
                }
                Some(Kind::Observation(Observation::Outliers)) => {
                    for e in &mut noise {
                        if random.random_range(0.0..1.0) < 0.005 * strength {
                            *e += sigma * random.random_range(-30.0..30.0);
                        }
                    }
                }
                _ => {}
            }
            for k in 0..samples {
                let value = &mut y[k * ny + c];
                *value += noise[k];
                if let Some(Kind::Observation(Observation::Quantised)) = observed.map(|t| t.kind) {
                    let q = sigma * strength;
                    *value = q * (*value / q).round();
                }
            }
        }
        let (inputs, outputs) = (model.external_inputs(), model.output_channels());
        logs.push(Record::new(inputs, outputs, u.clone(), y, ts).unwrap());
    }
    let held_out = logs.pop()?;
    let record = logs.pop()?;
    let is_good = effects == 0 || kind == "observed" || (1.0..80.0).contains(&size);
    is_good.then_some(Drawn { model, truths, record, held_out, scales, size })
}

fn name(candidate: &Candidate) -> String {
    format!("{}/{}@{}", candidate.label, candidate.law, candidate.site.name().unwrap_or("-"))
}

/// Whether the truth is the answer or tied with it; its group; its side.
fn right(d: &Diagnosis, truth: &Candidate) -> [bool; 3] {
    let is = |c: &fd_gap::diagnose::Cause| {
        c.label == truth.label && c.site == truth.site && c.partner == truth.partner
    };
    let group = &d.groups[0];
    [
        d.tied.iter().any(|i| is(&d.causes[*i])),
        group.family == mechanism(truth) && group.site == truth.site,
        d.sides[0].0 == truth.side,
    ]
}

#[test]
#[ignore = "a survey, not a test"]
fn survey() {
    let kind = std::env::var("SURVEY").unwrap_or_else(|_| "single".into());
    let number = |name: &str, default| {
        std::env::var(name).ok().and_then(|n| n.parse().ok()).unwrap_or(default)
    };
    let (cases, first) = (number("CASES", 20), number("FIRST", 1));
    let (mut done, mut seed) = (0, first);
    let mut counts = [0; 3];
    let mut verdicts: Vec<(String, usize)> = Vec::new();
    let begin = Instant::now();
    while done < cases {
        seed += 1;
        let Some(drawn) = draw(&kind, seed) else { continue };
        done += 1;
        let Drawn { model, truths, record, held_out, scales, size } = drawn;
        let mut suspects = EverySite::new(library(), &model, scales);
        if kind == "withheld" {
            suspects = suspects.without(&[truths[0].label.to_owned(), truths[0].family.to_owned()]);
        }
        let case =
            Case { nominal: &model, suspects: &suspects, logs: &[record], held_out: &[held_out] };
        let start = Instant::now();
        let d = diagnose(&case, &Settings::default(), &()).unwrap();
        let time = start.elapsed();
        let hits = truths.first().map(|truth| right(&d, truth));
        if let Some(hits) = hits {
            hits.iter().zip(&mut counts).for_each(|(hit, n)| *n += usize::from(*hit));
        }
        let verdict = format!("{:?}", d.verdict);
        match verdicts.iter_mut().find(|(v, _)| *v == verdict) {
            Some((_, n)) => *n += 1,
            None => verdicts.push((verdict.clone(), 1)),
        }
        let best = &d.causes[0];
        let pair = d.pairs.first().map(|p| {
            let names = p.causes.each_ref().map(|c| format!("{}@{:?}", c.label, c.site.name()));
            format!("pair {names:?} p {:.3} Z {:.1}", p.probability, p.log_evidence)
        });
        println!(
            "{seed:>4} {:<20} {:<40} size {size:>5.1} | {verdict:<12} {:?} | no {:.3} none {:.3} | {}/{}@{} p {:.3} Z {:.1} gap {:.2}->{:.2} | level {:.1} pattern {:.1} share {:.3} unexpl {} col {} | {} | {:.2}s {}",
            model.name,
            truths.iter().map(name).collect::<Vec<_>>().join(" + "),
            hits.map(|h| h.map(u8::from)),
            d.no_gap,
            d.none_of_these,
            best.label,
            best.law,
            best.site.name().unwrap_or("-"),
            best.probability,
            best.log_evidence,
            d.refit.gap.iter().copied().fold(0.0, f64::max),
            d.best.gap.iter().copied().fold(0.0, f64::max),
            d.leftover.level,
            d.leftover.pattern,
            d.leftover.share,
            u8::from(d.is_unexplained),
            u8::from(d.is_coloured),
            pair.unwrap_or_default(),
            time.as_secs_f64(),
            d.simulations,
        );
    }
    println!(
        "{kind}: {done} cases, label|group|side {counts:?}, {verdicts:?}, {:?}",
        begin.elapsed()
    );
}
