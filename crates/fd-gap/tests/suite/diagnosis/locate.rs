//! The gap is found where it is, and nowhere when there is none.

use std::time::Instant;

use fd_effect::SiteRef;
use fd_gap::{
    diagnose::{Case, Diagnosis, Settings, diagnose},
    fit::Horizon,
    locate::{Location, Region, RegionOf, RegionOn, locate},
};
use fd_model::Record;
use fd_sim::{
    model::{Model, Parameter},
    patch::Patch,
};

use crate::diagnosis::bench_cases::{Reality, candidates, example, expr, record, sizes};

fn reality(amplitude: f64, seed: u64) -> Reality {
    Reality { samples: 1000, amplitude, parameter_error: 0.03, colour: 0.0, seed }
}

fn run(model: &Model, size: &str, logs: &[Record], settings: &Settings) -> (Diagnosis, Location) {
    let suspects = candidates(model, sizes(size));
    let case = Case { nominal: model, suspects: &suspects, logs, held_out: &[] };
    let diagnosis = diagnose(&case, settings, &()).unwrap();
    let begin = Instant::now();
    let location = locate(&case, &diagnosis, &()).unwrap();
    println!("located in {:?}", begin.elapsed());
    (diagnosis, location)
}

fn print(location: &Location) {
    for channel in &location.channels {
        println!("{}", channel.statement);
    }
    for side in &location.sides {
        println!("{}", side.statement);
    }
    for place in &location.places {
        println!(
            "{} {:?}",
            place.statement,
            place.free.as_ref().map(|f| (f.share, f.log_evidence))
        );
    }
    for spectrum in &location.spectra {
        println!("{}", spectrum.statement);
        for band in &spectrum.bands {
            println!("  {band:?}");
        }
    }
    for region in &location.regions {
        println!(
            "{:.3} {:.3} {:.3} {}",
            region.p_value, region.level_share, region.size_share, region.statement
        );
    }
    for time in &location.times {
        println!(
            "{} {:?}",
            time.statement,
            time.stretches.iter().map(|s| s.refit).collect::<Vec<_>>()
        );
    }
}

/// The first region, which is the velocity, or its sign; and that of the sign.
fn direction(location: &Location) -> &Region {
    let is_sign = |on: &RegionOn| *on == RegionOn::Direction("carriage".into());
    let first = &location.regions[0];
    assert!(is_sign(&first.on) || first.on == RegionOn::State("v".into()), "{first:?}");
    let region = location.regions.iter().find(|region| is_sign(&region.on)).unwrap();
    assert!(region.is_significant, "{region:?}");
    region
}

fn friction() -> Model {
    let mut patch = Patch::of(&example("mass_spring_damper"));
    patch.add_parameter(Parameter::new("true_f", "N", 0.4));
    let law = expr("-true_f*v/sqrt(v^2 + 0.004^2)");
    patch.add_force("carriage", "friction", law).unwrap();
    patch.finish().unwrap()
}

#[test]
fn friction_depends_on_the_direction() {
    let model = example("mass_spring_damper");
    let log = record(&friction(), reality(10.0, 3), 1);
    let (_, location) = run(&model, "mass_spring_damper", &[log], &Settings::default());
    print(&location);
    let first = &location.places[0];
    assert_eq!(first.site, SiteRef::Force(0, "carriage".into()));
    assert_eq!(first.equations, ["v"]);
    assert!(0.9 < first.probability);
    let free = first.free.as_ref().unwrap();
    assert!(0.8 < free.share, "{}", free.share);
    // A force of 0.4 N whose sign changes, less what the refitted damping takes of it, smoothed by the knots.
    assert!(0.1 < free.rms && free.rms < 0.5, "{}", free.rms);
    let region = direction(&location);
    assert_eq!(region.of, RegionOf::Signal(first.site.clone()));
    // It works against the motion.
    assert!(region.bins[1].mean < -0.1 && 0.1 < region.bins[0].mean, "{:?}", region.bins);
    assert!(location.spectra[0].bands.iter().any(|band| band.is_above_floor));
    assert!(location.spectra[0].bands.iter().all(|band| !band.is_above_floor_after));
}

#[test]
fn windows_are_located_too() {
    let model = example("mass_spring_damper");
    let logs = [1, 2].map(|seed| record(&friction(), reality(10.0, 3), seed).slice(0, 600));
    let settings = Settings { horizon: Horizon::Windows { samples: 100 }, ..Settings::default() };
    let (_, location) = run(&model, "mass_spring_damper", &logs, &settings);
    print(&location);
    assert_eq!(location.places[0].site.name(), Some("carriage"));
    assert_eq!(location.times.len(), 2);
    assert!(direction(&location).level_share > 0.3);
}

#[test]
fn a_push_is_found_in_time() {
    // A force that no candidate knows, from 4 s to 6 s of 10 s.
    let model = example("mass_spring_damper");
    let mut patch = Patch::of(&model);
    patch
        .add_force("carriage", "push", expr("0.8*max(0, min(1, min(50*(t - 4), 50*(6 - t))))"))
        .unwrap();
    let log = record(&patch.finish().unwrap(), reality(6.0, 8), 1);
    let (_, location) = run(&model, "mass_spring_damper", &[log], &Settings::default());
    print(&location);
    let change = location.times[0].change.unwrap();
    assert!((change.from - 4.0).abs() < 0.5, "{change:?}");
    // It rings for a while afterwards: 2 m/d = 2.7 s.
    assert!(5.5 < change.to && change.to < 9.5, "{change:?}");
    assert!(2.0 * change.outside < change.inside);
    let carriage = location.places.iter().find(|p| p.site.name() == Some("carriage")).unwrap();
    let values = &carriage.free.as_ref().unwrap().values[0];
    let mean = |from: usize, to: usize| values[from..to].iter().sum::<f64>() / (to - from) as f64;
    assert!(0.5 < mean(420, 580) - mean(100, 350), "{} {}", mean(420, 580), mean(100, 350));
}

#[test]
fn noise_makes_few_claims() {
    let (mut bands, mut regions, mut times) = (0, 0, 0);
    let cases = 24;
    for seed in 0..cases {
        let name = if seed % 2 == 0 { "mass_spring_damper" } else { "dc_drive" };
        let amplitude = if seed % 2 == 0 { 10.0 } else { 20.0 };
        let colour = if seed % 4 < 2 { 0.0 } else { 0.6 };
        let model = example(name);
        let reality = Reality { colour, samples: 400, ..reality(amplitude, 300 + seed) };
        let log = record(&model, reality, 1);
        let case = Case { nominal: &model, suspects: &Vec::new(), logs: &[log], held_out: &[] };
        let diagnosis = diagnose(&case, &Settings::default(), &()).unwrap();
        let location = locate(&case, &diagnosis, &()).unwrap();
        let band = location.spectra.iter().any(|s| s.bands.iter().any(|b| b.is_above_floor));
        let region = location.regions.iter().any(|region| region.is_significant);
        let time = location.times.iter().any(|time| time.change.is_some());
        if band || region || time {
            println!(
                "{seed} {name} {colour}: {band} {region} {time} coloured {}",
                diagnosis.is_coloured
            );
            print(&location);
        }
        bands += u32::from(band);
        regions += u32::from(region);
        times += u32::from(time);
    }
    println!("{bands} {regions} {times} of {cases}");
    // At 5 %, five or more of 24 come by chance in 0.6 % (binomial).
    assert!(bands <= 4 && regions <= 4 && times <= 4);
}

#[test]
fn names_order_and_units_do_not_matter() {
    let model = example("dc_drive");
    let mut patch = Patch::of(&model);
    patch.add_force("shaft", "friction", expr("-0.02*omega/sqrt(omega^2 + 1.5)")).unwrap();
    let log = record(&patch.finish().unwrap(), reality(20.0, 21), 1).slice(0, 500);
    let (_, plain) = run(&model, "dc_drive", std::slice::from_ref(&log), &Settings::default());
    print(&plain);

    let other = log.in_units(&["mV"], &["mA", "rpm"]).unwrap();
    let outputs = vec![other.outputs()[1].clone(), other.outputs()[0].clone()];
    let rows = (0..other.len()).map(|k| (vec![other.u(k)[0]], vec![other.y(k)[1], other.y(k)[0]]));
    let shuffled = Record::from_rows(other.inputs().to_vec(), outputs, rows, other.ts()).unwrap();
    let (_, same) = run(&model, "dc_drive", &[shuffled], &Settings::default());
    let evidence = |location: &Location| -> Vec<(SiteRef, f64, f64)> {
        let places = location.places.iter();
        places.map(|p| (p.site.clone(), p.probability, p.free.as_ref().unwrap().share)).collect()
    };
    for (a, b) in evidence(&plain).iter().zip(&evidence(&same)) {
        // Conversions round to 1e-16, and searches stop within 1e-3 of the least cost.
        assert!(a.0 == b.0 && (a.1 - b.1).abs() < 1e-2 && (a.2 - b.2).abs() < 1e-3, "{a:?} {b:?}");
    }

    let rename = |text: &str| text.replace("current", "amperes").replace("speed", "rate");
    let renamed: Model = rename(&model.to_string()).parse().unwrap();
    let rows = log.samples().map(|(u, y)| (u.to_vec(), y.to_vec()));
    let inputs = log.inputs().to_vec();
    let log = Record::from_rows(inputs, renamed.output_channels(), rows, log.ts()).unwrap();
    let suspects = candidates(&renamed, |what: &str| match what {
        "amperes" => sizes("dc_drive")("current"),
        "rate" => sizes("dc_drive")("speed"),
        other => sizes("dc_drive")(other),
    });
    let case = Case { nominal: &renamed, suspects: &suspects, logs: &[log], held_out: &[] };
    let diagnosis = diagnose(&case, &Settings::default(), &()).unwrap();
    let same = locate(&case, &diagnosis, &()).unwrap();
    let bits = |location: &Location| -> Vec<[u64; 2]> {
        let places = location.places.iter();
        places.map(|p| [p.probability, p.free.as_ref().unwrap().share].map(f64::to_bits)).collect()
    };
    assert_eq!(bits(&plain), bits(&same));
}

/// Controllers, several inputs, overflow, unstable plants: everything has a finite answer.
#[test]
fn every_example_can_be_located() {
    let names = [
        ("cart_pole", 1.0),
        ("dc_drive_closed_loop", 100.0),
        ("pendulum", 0.5),
        ("tanks", 1e-4),
        ("two_input", 1.0),
        ("two_mass_drive", 1.0),
    ];
    for (name, amplitude) in names {
        let model = example(name);
        let log = record(&model, Reality { samples: 400, ..reality(amplitude, 4) }, 1);
        let settings =
            Settings { horizon: Horizon::Windows { samples: 50 }, ..Settings::default() };
        let case = Case { nominal: &model, suspects: &Vec::new(), logs: &[log], held_out: &[] };
        let diagnosis = diagnose(&case, &settings, &()).unwrap();
        let begin = Instant::now();
        let location = locate(&case, &diagnosis, &()).unwrap();
        println!("{name}: {:?}", begin.elapsed());
        assert_eq!(location.channels.len(), model.outputs.len());
        for place in &location.places {
            println!("  {}", place.statement);
            let free = place.free.as_ref();
            assert!(free.is_none_or(|f| (0.0..=1.0).contains(&f.share) && f.rms.is_finite()));
        }
        for spectrum in &location.spectra {
            let sum: f64 = spectrum.bands.iter().map(|band| band.refit).sum();
            let c = model.outputs.iter().position(|o| o.name == spectrum.output).unwrap();
            // The window weighs samples differently, so that a gap that is not stationary (windows
            // end in larger errors than they begin with) has not exactly its mean square.
            let square = diagnosis.refit.gap[c].powi(2);
            assert!((sum - square).abs() < 0.25 * square, "{} {sum} {square}", spectrum.output);
        }
    }
}
