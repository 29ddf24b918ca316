//! `fdiag gap`: which unmodelled effect separates a simulator from logs of the real system.
//!
//! [`GapStudy::run`] reads a model and logs, diagnoses them with [`fd_gap`], and puts everything
//! that came out into one [`Report`], from which sentence, tables, pictures and JSON are made.

mod data;
mod error;
mod findings;
mod headline;
mod law;
mod memory;
mod only;
mod page;
mod patched;
mod pictures;
mod report;
mod request;
mod study;
mod subject;
mod summary;
mod tables;
mod traces;
mod words;

pub use fd_gap::{
    diagnose::{Monitor, Stage},
    fit::FitError,
};

pub use self::{
    error::GapError,
    report::{
        AdviceReport, BandReport, BinReport, CalibrationReport, CauseReport, CeilingReport,
        ChannelReport, ClosedReport, CompensationReport, FileReport, FindingReport, GroupReport,
        HorizonReport, InputReport, LawReport, LeftoverReport, LogReport, NoiseReport,
        NotTestedReport, NuisanceReport, OutputGap, PairReport, ParameterReport, PlaceReport,
        REPORT_VERSION, RegionReport, Report, SettingsReport, SideReport, SiteReport, SizeReport,
        SpectrumReport, StretchReport, TimesReport, TimingReport, TriedExperiment, WhereReport,
        WorkReport,
    },
    request::{HeldOutChoice, HorizonChoice, Named, Request, ResampleChoice},
    study::{GapStudy, automatic_settings},
    subject::Subject,
};
