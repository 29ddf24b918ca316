//! A simulator that shows no states: the run of a fitted part goes on into the held-out one
//! (`../shared/data/people/p04-heldout-tail`).

use fd_effect::Candidate;
use fd_gap::{
    diagnose::{Case, Settings, Verdict, diagnose},
    fit::Log,
};
use fd_model::{Channel, Record, SampleTime, signal::WhiteNoise};
use fd_sim::{
    model::Parameter,
    simulate::{Initial, Port, Shell, Simulator},
};

/// Nothing is looked for.
const NONE: Vec<Candidate> = Vec::new();

/// Noise of the temperature, in K.
const NOISE: f64 = 0.03;

/// A room that warms from 16 degrees, with a time constant of 400 samples.
#[derive(Clone, Debug)]
struct Room {
    inputs: [Channel; 1],
    outputs: [Channel; 1],
    parameters: [Parameter; 1],
    resistance: f64,
    temperature: f64,
}

impl Room {
    fn new() -> Self {
        let resistance = Parameter { tolerance: 0.05, ..Parameter::new("R", "K/W", 0.02) };
        Self {
            inputs: [Channel::new("heat", "W")],
            outputs: [Channel::new("T", "degC")],
            parameters: [resistance],
            resistance: 0.02,
            temperature: 16.0,
        }
    }
}

impl Simulator for Room {
    fn ts(&self) -> SampleTime {
        SampleTime::new(10.0).unwrap()
    }

    fn inputs(&self) -> &[Channel] {
        &self.inputs
    }

    fn outputs(&self) -> &[Channel] {
        &self.outputs
    }

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn initial(&self) -> &[Initial] {
        &[]
    }

    fn ports(&self) -> &[Port] {
        &[]
    }

    fn natives(&self) -> &[fd_sim::simulate::NativeEffect] {
        &[]
    }

    fn start(&mut self, theta: &[f64], _x0: &[f64], _first: u64) {
        (self.resistance, self.temperature) = (theta[0], 16.0);
    }

    fn step(&mut self, u: &[f64], _u_next: &[f64], _f: &[f64], y: &mut [f64]) {
        y[0] = self.temperature;
        self.temperature += 10.0 * (u[0] - (self.temperature - 5.0) / self.resistance) / 2.0e5;
    }

    fn measure(&mut self, _u: &[f64], y: &mut [f64]) -> bool {
        y[0] = self.temperature;
        true
    }

    fn state(&self) -> &[f64] {
        &[]
    }

    fn boxed(&self) -> Box<dyn Simulator> {
        Box::new(self.clone())
    }
}

/// A log of the room itself.
fn log() -> Record {
    let mut room = Room::new();
    room.start(&[0.02], &[], 0);
    let u: Vec<f64> = (0..900).map(|k| [200.0, 800.0, 500.0][k / 150 % 3]).collect();
    let noise = WhiteNoise::new(NOISE, 4).values(900).unwrap();
    let mut y = vec![0.0; 900];
    for (k, y) in y.iter_mut().enumerate() {
        room.step(&u[k..=k], &u[k..=k], &[], std::slice::from_mut(y));
        *y += noise[k];
    }
    Record::new(room.inputs.to_vec(), room.outputs.to_vec(), u, y, room.ts()).unwrap()
}

#[test]
fn a_held_out_part_goes_on_where_the_fitted_run_had_brought_the_plant() {
    let shell = Shell::new("room", Box::new(Room::new())).unwrap().with_noise(&[Some(NOISE)]);
    let whole = log();
    let (fitted, held_out) = (whole.slice(0, 600), whole.slice(600, 900));
    let simulator = Room::new();
    let behind = Log::new(&held_out, &simulator, 1)
        .unwrap()
        .continuing(&held_out, std::slice::from_ref(&fitted), &simulator)
        .unwrap();
    assert_eq!((behind.samples(), behind.lead(), behind.first()), (900, 600, 0));
    assert!(behind.output(599)[0].is_nan() && behind.output(600) == held_out.y(0));
    assert_eq!((behind.input(0), behind.input(600)), (fitted.u(0), held_out.u(0)));

    let case = Case { nominal: &shell, suspects: &NONE, logs: &[fitted], held_out: &[held_out] };
    let diagnosis = diagnose(&case, &Settings::default(), &()).unwrap();
    assert_eq!(diagnosis.verdict, Verdict::NoGap);
    let free = &diagnosis.held_out[0];
    // 300 values: five standard deviations of their root mean square are a fifth of it.
    assert!(free.seconds == 3000.0 && (free.refit[0] / NOISE - 1.0).abs() < 0.25, "{free:?}");
}
