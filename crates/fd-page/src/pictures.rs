//! The pictures of a report.

use fd_gap::{
    diagnose::Cause,
    locate::{Band, PlaceEvidence, Region, RegionOf, Spectrum, TimeCourse},
};
use fd_model::duration;
use fd_report::{Line, Picture};

use fdiag::{
    gap_study::{
        Law, Report, Role, Signals, Trace,
        words::{self, region_of, region_on},
    },
    ident::diagnostics::autocorrelation,
};

/// A picture and what it says.
pub(crate) type Captioned = (Picture, String);

/// Most outputs, spectra, regions and logs that are drawn; the JSON has them all.
const MOST: usize = 3;
/// Part of a run that the zoom shows.
const ZOOM: usize = 12;
/// Fewest samples that it shows.
const LEAST_ZOOM: usize = 40;
/// Most and fewest lags of an autocorrelation, which is drawn up to a quarter of the run.
const MOST_LAGS: usize = 200;
const LEAST_LAGS: usize = 5;
/// Standard deviations within which 95 % of a Gaussian variable lies.
const WHITE: f64 = 1.96;

/// Real against simulated, before and after: each output as a whole and where it matters most.
pub(crate) fn runs(trace: &Trace) -> Vec<Captioned> {
    let which = match (trace.role, trace.window) {
        (Role::HeldOut, None) => {
            "Held-out data, which no fit has seen; the first part settles the initial state"
                .to_owned()
        }
        (Role::HeldOut, Some(window)) => format!(
            "Held-out data, which no fit has seen, in windows of {}; the first half of each settles its initial state",
            duration(window)
        ),
        (Role::Fit, _) => "Data that were fitted to".to_owned(),
    };
    let mut pictures = Vec::new();
    for signals in trace.outputs.iter().take(MOST) {
        let n = trace.time.len();
        let caption = format!("{which}.");
        pictures.push((run(trace, signals, 0, n, &signals.name), caption));
        let (from, to) = zoom(signals, n);
        if (from, to) != (0, n) {
            let title = format!("{}, where it matters most", signals.name);
            let caption = "The stretch in which the best explanation changes most.".to_owned();
            pictures.push((run(trace, signals, from, to, &title), caption));
        }
    }
    pictures
}

fn run(trace: &Trace, signals: &Signals, from: usize, to: usize, title: &str) -> Picture {
    let line = |name: &str, values: &[f64]| {
        let time = trace.time.iter().copied();
        Line::new(name, time.zip(values.iter().copied()).take(to).skip(from))
    };
    Picture {
        title: title.to_owned(),
        x_label: "time [s]".to_owned(),
        y_label: format!("{} [{}]", signals.name, signals.unit),
        lines: vec![
            line("measured", &signals.measured),
            line("simulated before", &signals.before),
            line("simulated after", &signals.after),
        ],
        ..Picture::default()
    }
}

/// The stretch in which before and after differ most.
fn zoom(signals: &Signals, n: usize) -> (usize, usize) {
    let length = (n / ZOOM).max(LEAST_ZOOM);
    if n <= 2 * length {
        return (0, n);
    }
    let pairs = signals.before.iter().zip(&signals.after);
    let squares: Vec<f64> = pairs
        .map(|(b, a)| (b - a) * (b - a))
        .map(|square| if square.is_finite() { square } else { 0.0 })
        .collect();
    let step = (length / 4).max(1);
    let energy = |from: &usize| squares.iter().skip(*from).take(length).sum::<f64>();
    let starts = (0..n - length).step_by(step);
    let from = starts.max_by(|a, b| energy(a).total_cmp(&energy(b))).unwrap_or(0);
    (from, from + length)
}

/// What is behind these: the outputs that are not among them, the inputs, what is left of each output, and whether
/// that remembers itself.
pub(crate) fn behind(trace: &Trace) -> Vec<Captioned> {
    let (n, time) = (trace.time.len(), || trace.time.iter().copied());
    let others = trace
        .outputs
        .iter()
        .skip(MOST)
        .map(|signals| (run(trace, signals, 0, n, &signals.name), String::new()));
    let inputs = trace.inputs.iter().map(|input| {
        let picture = Picture {
            title: format!("Input {}", input.name),
            x_label: "time [s]".to_owned(),
            y_label: format!("{} [{}]", input.name, input.unit),
            lines: vec![Line::new("", time().zip(input.values.iter().copied()))],
            ..Picture::default()
        };
        (picture, String::new())
    });
    let left = trace.outputs.iter().flat_map(|signals| {
        let left = |simulated: &[f64]| -> Vec<f64> {
            signals.measured.iter().zip(simulated).map(|(y, simulated)| y - simulated).collect()
        };
        let left = [("before", left(&signals.before)), ("after", left(&signals.after))];
        let over_time = Picture {
            title: format!("Residual of {}", signals.name),
            x_label: "time [s]".to_owned(),
            y_label: format!("residual [{}]", signals.unit),
            lines: left
                .iter()
                .map(|(name, left)| Line::new(*name, time().zip(left.iter().copied())))
                .collect(),
            ..Picture::default()
        };
        let caption = "Measured minus simulated.".to_owned();
        [Some((over_time, caption)), memory(trace, signals, left)].into_iter().flatten()
    });
    others.chain(inputs).chain(left).collect()
}

/// The autocorrelation of what is left; none of a run that is too short.
fn memory(trace: &Trace, signals: &Signals, left: [(&str, Vec<f64>); 2]) -> Option<Captioned> {
    let [first, .., last] = trace.time[..] else { return None };
    let samples = left[1].1.iter().filter(|e| e.is_finite()).count();
    let lags = (samples / 4).min(MOST_LAGS);
    if lags < LEAST_LAGS {
        return None;
    }
    let ts = (last - first) / (trace.time.len() - 1) as f64;
    let lines = left.map(|(name, left)| {
        let values = autocorrelation(&[left], lags);
        Line::new(name, values.into_iter().enumerate().map(|(lag, r)| (lag as f64 * ts, r)))
    });
    let band = WHITE / (samples as f64).sqrt();
    let picture = Picture {
        title: format!("Autocorrelation, {}", signals.name),
        x_label: "lag [s]".to_owned(),
        y_label: "autocorrelation of the residual [1]".to_owned(),
        lines: lines.into(),
        levels: vec![(band, "white noise".to_owned()), (-band, String::new())],
        ..Picture::default()
    };
    let caption = "White noise is within the dashed lines at 95 % of the lags; what remembers itself is not only noise.";
    Some((picture, caption.to_owned()))
}

/// The law over what it depends on, with what the data say without it.
pub(crate) fn law(law: &Law, cause: &Cause) -> Captioned {
    let points = |points: &[[f64; 2]]| points.iter().map(|[x, y]| (*x, *y)).collect::<Vec<_>>();
    let data =
        Line { dots: true, ..Line::new("from the data, without the law", points(&law.data)) };
    let curve = Line { dots: !law.is_curve, ..Line::new("fitted law", points(&law.points)) };
    let lines = if law.data.is_empty() { vec![curve] } else { vec![data, curve] };
    let picture = Picture {
        title: words::effect(cause),
        x_label: format!("{} [{}]", law.over, law.over_unit),
        y_label: format!(
            "{} [{}]",
            law.expression.split_once(" = ").map_or("", |(name, _)| name),
            law.unit
        ),
        lines,
        ..Picture::default()
    };
    let data = if law.data.is_empty() {
        ""
    } else {
        ". The points are what the model lacks here with its own parameters refitted; with the law \
         in it, these parameters take other values"
    };
    (picture, format!("`{}`{data}.", words::formula(&law.expression)))
}

/// Where the gap lies: frequency, region, time.
pub(crate) fn places(report: &Report) -> Vec<Captioned> {
    let location = &report.location;
    let spectra = location.spectra.iter().filter(|s| !s.bands.is_empty()).take(MOST);
    let regions = location.regions.iter().filter(|r| r.is_significant && !r.bins.is_empty());
    let times = location.times.iter().filter(|t| !t.stretches.is_empty()).take(MOST);
    let regions = regions.take(MOST).map(|of| region(of, &location.places));
    let pictures = spectra.map(spectrum).chain(regions);
    pictures.chain(times.map(|course| time(course, location.times.len()))).collect()
}

fn spectrum(spectrum: &Spectrum) -> Captioned {
    // Power per Hz, so that wide bands do not look strong.
    let line = |name: &str, power: &dyn Fn(&Band) -> f64| {
        let density = |b: &Band| power(b) / (b.high_hz - b.low_hz);
        let steps = spectrum.bands.iter().flat_map(|b| {
            let low = if b.low_hz > 0.0 { b.low_hz } else { 0.5 * b.high_hz };
            [(low, density(b)), (b.high_hz, density(b))]
        });
        Line::new(name, steps.collect::<Vec<_>>())
    };
    let picture = Picture {
        title: format!("Spectrum of the residual of {}", spectrum.output),
        x_label: "frequency [Hz]".to_owned(),
        y_label: "power [sigma²/Hz]".to_owned(),
        log_x: true,
        log_y: true,
        lines: vec![
            line("parameters refitted", &|b| b.refit),
            line("after", &|b| b.after),
            line("noise floor", &|b| b.floor),
        ],
        ..Picture::default()
    };
    (picture, spectrum.statement.clone())
}

fn region(region: &Region, places: &[PlaceEvidence]) -> Captioned {
    let (of, on) = (region_of(&region.of), region_on(&region.on));
    let unit = match &region.of {
        RegionOf::Residual(_) => "sigma",
        RegionOf::Signal(site) => {
            let free =
                places.iter().find(|place| place.site == *site).and_then(|p| p.free.as_ref());
            free.map_or("1", |free| &free.unit)
        }
    };
    let over = |value: &dyn Fn(usize) -> f64| -> Vec<(f64, f64)> {
        let bins = region.bins.iter().enumerate();
        bins.flat_map(|(i, b)| [(b.low, value(i)), (b.high, value(i))]).collect()
    };
    let bins = &region.bins;
    let picture = Picture {
        title: format!("The {of} over {on}"),
        x_label: format!("{on} [{}]", region.unit),
        y_label: format!("{of} [{unit}]"),
        lines: vec![
            Line::new("mean", over(&|i| bins[i].mean)),
            Line::new("rms", over(&|i| bins[i].rms)),
        ],
        ..Picture::default()
    };
    (picture, region.statement.clone())
}

fn time(course: &TimeCourse, logs: usize) -> Captioned {
    let line = |name: &str, value: &dyn Fn(usize) -> f64| {
        let stretches = course.stretches.iter().enumerate();
        let steps = stretches.flat_map(|(i, s)| [(s.from, value(i)), (s.to, value(i))]);
        Line::new(name, steps.collect::<Vec<_>>())
    };
    let stretches = &course.stretches;
    let which = if 1 < logs { format!(", log {}", course.log + 1) } else { String::new() };
    let picture = Picture {
        title: format!("The gap over time{which}"),
        x_label: "time [s]".to_owned(),
        y_label: "rms residual [sigma]".to_owned(),
        lines: vec![
            line("parameters refitted", &|i| stretches[i].refit),
            line("after", &|i| stretches[i].after),
        ],
        levels: vec![(1.0, "noise".to_owned())],
        ..Picture::default()
    };
    (picture, course.statement.clone())
}
