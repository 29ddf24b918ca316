//! Where the gap lies.

use fd_gap::locate::{
    Band, ChannelGap, FreeSignal, Location, PlaceEvidence, Region, RegionOf, RegionOn, Size,
    Spectrum, TimeCourse,
};
use serde::Serialize;

use super::{SiteReport, answer::side};
use crate::gap::words;

/// Where the gap lies.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct WhereReport {
    /// Gap of each output, on the fitted logs.
    pub channels: Vec<ChannelReport>,
    /// Evidence for each place.
    pub places: Vec<PlaceReport>,
    /// Power of the gap over frequency.
    pub spectra: Vec<SpectrumReport>,
    /// What the gap depends on, the strongest dependence first.
    pub regions: Vec<RegionReport>,
    /// The gap over time.
    pub times: Vec<TimesReport>,
}

/// The gap of an output, on the fitted logs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChannelReport {
    /// Name of the output.
    pub output: String,
    /// Its unit.
    pub unit: String,
    /// With the model as it came.
    pub before: SizeReport,
    /// With parameters refitted.
    pub refit: SizeReport,
    /// With the best explanation.
    pub after: SizeReport,
    /// Noise floor.
    pub floor: SizeReport,
    /// In words.
    pub statement: String,
}

/// A root mean square.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SizeReport {
    /// In the unit of the output.
    pub value: f64,
    /// In standard deviations of the noise.
    pub sigma: f64,
}

/// Evidence for a place.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlaceReport {
    /// The place.
    pub site: SiteReport,
    /// `input`, `dynamics` or `output`.
    pub side: &'static str,
    /// States whose equations a force here enters.
    pub equations: Vec<String>,
    /// Sum of the probabilities of the causes here.
    pub probability: f64,
    /// Share of the gap that a free signal here explains.
    pub free_share: Option<f64>,
    /// Root mean square of that signal.
    pub free_rms: Option<f64>,
    /// Its unit.
    pub free_unit: Option<String>,
    /// In words.
    pub statement: String,
}

/// Power of the gap of an output over frequency, in squares of the noise per sample.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SpectrumReport {
    /// Name of the output.
    pub output: String,
    /// Bands from low to high.
    pub bands: Vec<BandReport>,
    /// In words.
    pub statement: String,
}

/// A frequency band.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct BandReport {
    /// Lower end, in Hz.
    pub low_hz: f64,
    /// Upper end, in Hz.
    pub high_hz: f64,
    /// Power with parameters refitted.
    pub refit: f64,
    /// Power with the best explanation.
    pub after: f64,
    /// Power of the noise floor.
    pub floor: f64,
    /// Share of the power above the floor, with parameters refitted.
    pub share: f64,
    /// Whether the refitted model leaves significantly more than the floor.
    pub is_above_floor: bool,
    /// Whether the best explanation does.
    pub is_above_floor_after: bool,
    /// Share of the power that is linear in each input.
    pub coherence: Vec<Option<f64>>,
}

/// What the gap depends on.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RegionReport {
    /// What is looked at: the residual of an output or the missing signal at a place.
    pub of: String,
    /// The signal that it may depend on.
    pub on: String,
    /// Unit of that signal.
    pub unit: String,
    /// Bins from low to high.
    pub bins: Vec<BinReport>,
    /// Share of the variance that the means of the bins explain.
    pub level_share: f64,
    /// The same for the squares.
    pub size_share: f64,
    /// Probability of such shares by chance.
    pub p_value: f64,
    /// Whether they are more than chance.
    pub is_significant: bool,
    /// In words.
    pub statement: String,
}

/// A bin of a region.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BinReport {
    /// Lowest value of the signal.
    pub low: f64,
    /// Highest value of the signal.
    pub high: f64,
    /// Number of samples.
    pub samples: usize,
    /// Mean of what is looked at.
    pub mean: f64,
    /// Its root mean square.
    pub rms: f64,
}

/// The gap over the time of a log.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TimesReport {
    /// Number of the fitted log, from 1.
    pub log: usize,
    /// Stretches of about the same length.
    pub stretches: Vec<StretchReport>,
    /// In words.
    pub statement: String,
}

/// Part of a log.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StretchReport {
    /// Begin, in seconds.
    pub from_s: f64,
    /// End, in seconds.
    pub to_s: f64,
    /// Gap with parameters refitted, in sigma.
    pub refit: f64,
    /// Gap with the best explanation, in sigma.
    pub after: f64,
}

/// The law of the best explanation, along its simulation of the fitted logs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LawReport {
    /// What it is.
    pub name: String,
    /// Its expression in the patched model.
    pub expression: String,
    /// What it is drawn over.
    pub over: String,
    /// Unit of that.
    pub over_unit: String,
    /// Unit of the law.
    pub unit: String,
    /// Whether it is a curve (a value of the law for each value below).
    pub is_curve: bool,
    /// Points `[over, value]` of the law, in the order of `over` for a curve, else of time.
    pub points: Vec<[f64; 2]>,
    /// Points `[over, value]` that were estimated from the data without the law: the signal that
    /// the refitted model lacks at this place.
    pub data: Vec<[f64; 2]>,
}

impl From<&Location> for WhereReport {
    fn from(location: &Location) -> Self {
        Self {
            channels: location.channels.iter().map(ChannelReport::from).collect(),
            places: location.places.iter().map(PlaceReport::from).collect(),
            spectra: location.spectra.iter().map(SpectrumReport::from).collect(),
            regions: location.regions.iter().map(RegionReport::from).collect(),
            times: location.times.iter().map(TimesReport::from).collect(),
        }
    }
}

impl From<&ChannelGap> for ChannelReport {
    fn from(gap: &ChannelGap) -> Self {
        let size = |size: &Size| SizeReport { value: size.value, sigma: size.sigma };
        Self {
            output: gap.output.name.clone(),
            unit: gap.output.unit.clone(),
            before: size(&gap.nominal),
            refit: size(&gap.refit),
            after: size(&gap.after),
            floor: size(&gap.floor),
            statement: gap.statement.clone(),
        }
    }
}

impl From<&PlaceEvidence> for PlaceReport {
    fn from(place: &PlaceEvidence) -> Self {
        let free = place.free.as_ref();
        Self {
            site: SiteReport::from(&place.site),
            side: side(place.side),
            equations: place.equations.clone(),
            probability: place.probability,
            free_share: free.map(|free: &FreeSignal| free.share),
            free_rms: free.map(|free| free.rms),
            free_unit: free.map(|free| free.unit.clone()),
            statement: place.statement.clone(),
        }
    }
}

impl From<&Spectrum> for SpectrumReport {
    fn from(spectrum: &Spectrum) -> Self {
        let band = |band: &Band| BandReport {
            low_hz: band.low_hz,
            high_hz: band.high_hz,
            refit: band.refit,
            after: band.after,
            floor: band.floor,
            share: band.share,
            is_above_floor: band.is_above_floor,
            is_above_floor_after: band.is_above_floor_after,
            coherence: band.coherence.clone(),
        };
        Self {
            output: spectrum.output.clone(),
            bands: spectrum.bands.iter().map(band).collect(),
            statement: spectrum.statement.clone(),
        }
    }
}

impl From<&Region> for RegionReport {
    fn from(region: &Region) -> Self {
        let bins = region.bins.iter().map(|bin| BinReport {
            low: bin.low,
            high: bin.high,
            samples: bin.count,
            mean: bin.mean,
            rms: bin.rms,
        });
        Self {
            of: match &region.of {
                RegionOf::Residual(output) => format!("residual of {output}"),
                RegionOf::Signal(site) => format!("missing signal {}", words::at(site)),
            },
            on: match &region.on {
                RegionOn::Input(name) => format!("input {name}"),
                RegionOn::InputAmplitude(name) => format!("magnitude of input {name}"),
                RegionOn::State(name) => format!("state {name}"),
                RegionOn::StateAmplitude(name) => format!("magnitude of state {name}"),
                RegionOn::Output(name) => format!("output {name}"),
                RegionOn::Direction(site) => format!("direction of motion at {site}"),
            },
            unit: region.unit.clone(),
            bins: bins.collect(),
            level_share: region.level_share,
            size_share: region.size_share,
            p_value: region.p_value,
            is_significant: region.is_significant,
            statement: region.statement.clone(),
        }
    }
}

impl From<&TimeCourse> for TimesReport {
    fn from(course: &TimeCourse) -> Self {
        let stretches = course.stretches.iter().map(|stretch| StretchReport {
            from_s: stretch.from,
            to_s: stretch.to,
            refit: stretch.refit,
            after: stretch.after,
        });
        Self {
            log: course.log + 1,
            stretches: stretches.collect(),
            statement: course.statement.clone(),
        }
    }
}
