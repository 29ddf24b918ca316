//! Effects that a black box has in itself are tried like any other.

use fd_effect::{EverySite, NATIVE, SiteRef, library, natives, offers};
use fd_gap::{
    diagnose::{Case, Diagnosis, Settings, Verdict, diagnose},
    few_runs::{Effort, with_few_runs},
};
use fd_model::SampleTime;
use fd_sim::{
    scales::ReplayScales,
    simulate::{Nominal, Shell},
};

use super::pendulum::{Cause, Pendulum, TS, excitation, log, shell_of};

const SAMPLES: usize = 600;

fn shell() -> Shell {
    shell_of(Pendulum::new(TS).with_natives())
}

fn scales(shell: &Shell, u: &[f64]) -> ReplayScales {
    shell.scales(SampleTime::new(TS).unwrap(), u, u.len()).unwrap()
}

fn run(cause: Cause, seed: u64, is_spared: bool) -> Diagnosis {
    let (shell, record) = (shell(), log(cause, SAMPLES, seed));
    let u: Vec<f64> = record.samples().flat_map(|(u, _)| u.to_vec()).collect();
    let scales = scales(&shell, &u);
    let forces: Vec<f64> = scales.sites.iter().map(|site| site.force).collect();
    let effects = library().into_iter().chain(natives(&shell)).collect();
    let suspects = EverySite::new(effects, shell.model(), scales).without(&["map".to_owned()]);
    let logs = [record];
    let case = Case { nominal: &shell, suspects: &suspects, logs: &logs, held_out: &[] };
    let settings = Settings::default();
    let diagnosis = if is_spared {
        let few = with_few_runs(&shell, &forces, &case, &settings, Effort::default(), &());
        few.unwrap().unwrap().diagnosis
    } else {
        diagnose(&case, &settings, &()).unwrap()
    };
    println!("{cause:?}, spared {is_spared}: {:?}", diagnosis.verdict);
    for cause in diagnosis.causes.iter().take(5) {
        let values: Vec<_> =
            cause.parameters.iter().map(|p| (&p.name, p.value, p.standard_error)).collect();
        let (label, law, site) = (cause.label, cause.law, cause.site.name());
        println!(
            "  {label}@{site:?} {law} p {:.4} gap {:.3} {values:?}",
            cause.probability, cause.gap
        );
    }
    diagnosis
}

#[test]
fn at_rest_they_change_nothing_and_a_candidate_moves_its_own() {
    let (shell, plain) = (shell(), shell_of(Pendulum::new(TS)));
    let ts = SampleTime::new(TS).unwrap();
    let u = excitation(200, 0.8, 3);
    let outputs = |shell: &Shell, theta: &[f64], more: &str| {
        let all = offers(&natives(shell), shell.model(), &scales(shell, &u));
        let candidate = all.into_iter().flatten().find(|c| c.label == more);
        let model = candidate.map_or_else(|| shell.model().clone(), |c| c.model);
        let mut y = vec![0.0; 400];
        shell.patched(&model, ts).unwrap().simulate(theta, &[0.0; 2], &u, &mut y);
        y
    };
    let nominal = plain.model().nominal();
    let expected = outputs(&plain, &nominal, "");
    // Equal to the bit: a neutral friction adds a zero, and 0.05 + 0 is 0.05.
    assert_eq!(outputs(&shell, &nominal, ""), expected);
    let mut pendulum = Pendulum::new(TS).with_natives();
    for (i, label) in ["coulomb-friction", "rotor-inertia", "viscous-friction"].iter().enumerate() {
        let with = |value: f64| [&nominal[..], &[value]].concat();
        assert_eq!(outputs(&shell, &with(0.0), label), expected, "{label}");
        let mut theta = [&nominal[..], &[0.0; 3]].concat();
        theta[3 + i] = 0.02;
        let mut y = vec![0.0; 400];
        fd_sim::simulate::Simulator::simulate(&mut pendulum, &theta, &[0.0; 2], &u, &mut y);
        assert_ne!(y, expected, "{label}");
        assert_eq!(outputs(&shell, &with(0.02), label), y, "{label}");
    }
    // What is inside then, for whoever writes it down.
    let all = offers(&natives(&shell), shell.model(), &scales(&shell, &u));
    let model = &all[1].as_ref().unwrap().model;
    assert_eq!(shell.handed_on(model).unwrap(), [&nominal[..], &[0.0; 3]].concat());
    assert!(shell.passes_on(model).unwrap());
}

#[test]
fn a_law_of_the_library_and_the_own_one_are_one_cause() {
    let (shell, u) = (shell(), excitation(300, 0.8, 3));
    let scales = scales(&shell, &u);
    let of = |label: &str| {
        let effects: Vec<_> = library().into_iter().chain(natives(&shell)).collect();
        let all = offers(&effects, shell.model(), &scales).into_iter().flatten();
        all.filter(|c| c.label == label && c.site.name() == Some("pivot")).collect::<Vec<_>>()
    };
    for label in ["viscous-friction", "coulomb-friction"] {
        let laws = of(label);
        let (first, own) = (&laws[0], laws.last().unwrap());
        assert_eq!((own.law, own.identity()), (NATIVE, first.identity()));
        assert_eq!(own.family, first.family);
        // The same number, so that a fit of one starts the other.
        assert_eq!(own.parameters[0].name, first.parameters[0].name);
        assert_eq!(own.parameters[0].scale, first.parameters[0].scale);
        // As far as the simulator goes, however little the replay moves; divided by the scale and multiplied.
        let (low, high) = (own.parameters[0].low, own.parameters[0].high);
        assert!(low == 0.0 && (high - 10.0).abs() < 1e-12, "{label}: {low} to {high}");
        assert!(first.parameters[0].high < high, "{label}");
    }
}

#[test]
fn friction_of_its_own_is_named_where_a_held_force_only_comes_near() {
    for is_spared in [false, true] {
        let diagnosis = run(Cause::Coulomb(0.06), 11, is_spared);
        let first = &diagnosis.causes[0];
        assert_eq!(diagnosis.verdict, Verdict::Cause);
        assert_eq!((first.label, first.law), ("coulomb-friction", NATIVE));
        assert_eq!(first.site.name(), Some("pivot"));
        assert!(0.9 < first.probability, "{}", first.probability);
        let found = &first.parameters[0];
        assert!((found.value - 0.06).abs() < 4.0 * found.standard_error, "{found:?}");
        let again = diagnosis.causes.iter().filter(|c| c.label == first.label).count();
        assert_eq!(again, 1, "one answer");
    }
}

#[test]
fn what_a_parameter_explains_as_well_is_tied_with_it() {
    let diagnosis = run(Cause::Inertia(0.3), 11, false);
    assert_eq!(diagnosis.verdict, Verdict::Tied);
    let tied: Vec<_> = diagnosis.tied.iter().map(|id| &diagnosis.causes[id.0]).collect();
    let rotor = tied.iter().find(|cause| cause.label == "rotor-inertia").unwrap();
    assert_eq!(rotor.site, SiteRef::Part(1, "rotor 1".to_owned()));
    assert!(tied.iter().any(|c| (c.label, c.site.name()) == ("parameter-error", Some("J"))));
    // 30 % of an inertia that is itself known to 3 %.
    assert!((rotor.parameters[0].value - 0.015).abs() < 0.004, "{:?}", rotor.parameters);
}
