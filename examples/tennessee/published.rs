//! Published detection rates on the data set d00 .. d21, in per cent of the samples after the fault began.
//!
//! Each was read in a text that anyone can read, which is not always the paper itself:
//! `docs/results/tennessee.md` says which, and what is known of the conditions.

/// One published column; faults that it does not have are not numbers.
pub(crate) struct Published {
    pub(crate) name: &'static str,
    pub(crate) rates: [f64; 21],
    /// Samples above the limit without a fault.
    pub(crate) false_alarms: f64,
}

const NONE: f64 = f64::NAN;

/// Yin, Ding, Haghani, Hao and Zhang (2012), J. Process Control 22, table 4 with 5: 9 components, a sample
/// counts when T² or SPE is above its limit.
pub(crate) const YIN_9: Published = Published {
    name: "Yin, PCA 9",
    rates: [
        99.88, 98.75, 12.88, 100.0, 33.63, 100.0, 100.0, 98.0, 8.38, 60.5, 78.88, 99.13, 95.38,
        100.0, 14.13, NONE, NONE, NONE, NONE, NONE, NONE,
    ],
    false_alarms: 6.13,
};

/// The same, table 7 with 8: 17 components.
pub(crate) const YIN_17: Published = Published {
    name: "Yin, PCA 17",
    rates: [
        100.0, 99.38, 10.25, 100.0, 34.75, 100.0, 100.0, 98.63, 9.88, 71.0, 83.0, 99.0, 95.75,
        100.0, 17.25, NONE, NONE, NONE, NONE, NONE, NONE,
    ],
    false_alarms: 6.38,
};

/// The same paper as Spina et al. (2024), Digital Chemical Engineering 12, table 6, have it: dynamic PCA, 17
/// components.
pub(crate) const YIN_DYNAMIC: Published = Published {
    name: "Yin, DPCA 17",
    rates: [
        99.88, NONE, 12.88, NONE, 43.25, NONE, NONE, NONE, NONE, NONE, NONE, NONE, NONE, NONE,
        NONE, NONE, NONE, NONE, NONE, NONE, NONE,
    ],
    false_alarms: 10.13,
};

/// Lv, Wen, Bao and Liu (2016) as Agarwal, Gonzalez, Elkamel and Budman (2022), Processes 10, table 3, have it:
/// the T² of PCA.
pub(crate) const LV_T2: Published = Published {
    name: "Lv, PCA T²",
    rates: [
        99.2, 98.0, NONE, 4.4, 22.5, 98.9, 91.5, 96.6, NONE, 33.4, 20.6, 97.1, 94.0, 84.2, NONE,
        16.6, 74.1, 88.7, 0.4, 29.9, NONE,
    ],
    false_alarms: NONE,
};

/// The same: SPE.
pub(crate) const LV_Q: Published = Published {
    name: "Lv, PCA Q",
    rates: [
        99.8, 98.6, NONE, 96.2, 25.4, 100.0, 100.0, 97.6, NONE, 34.1, 64.4, 97.5, 95.5, 100.0,
        NONE, 24.5, 89.2, 89.9, 12.7, 45.0, NONE,
    ],
    false_alarms: NONE,
};

/// Li, Yang and Cao (2023), Processes 11, table 1: deep dynamic PCA, T² or Q; false alarms are the mean over
/// the first 160 samples of the twenty faulty runs.
pub(crate) const DEEP: Published = Published {
    name: "Li, DeDPCA",
    rates: [
        99.25, 99.25, 5.63, 100.0, 100.0, 100.0, 100.0, 99.0, 5.13, 94.13, 93.88, 100.0, 96.13,
        100.0, 36.88, 96.75, 97.75, 90.88, 99.63, 92.0, NONE,
    ],
    false_alarms: 3.47,
};

/// The same: kernels of canonical variates, the best of that paper.
pub(crate) const VARIATE_KERNELS: Published = Published {
    name: "Li, CVKA",
    rates: [
        99.75, 99.38, 3.75, 100.0, 100.0, 100.0, 100.0, 99.38, 5.25, 93.63, 94.88, 100.0, 96.5,
        100.0, 37.75, 96.88, 97.75, 91.38, 99.88, 92.0, NONE,
    ],
    false_alarms: 2.53,
};

/// Diallo et al. (2025), J. Process Control 152, table 1: false alarms on `d00_te` of PCA with 11 components by
/// parallel analysis, limits by formula: level, T², SPE.
pub(crate) const DIALLO: [(f64, f64, f64); 2] = [(0.99, 1.67, 7.08), (0.95, 7.60, 20.10)];
