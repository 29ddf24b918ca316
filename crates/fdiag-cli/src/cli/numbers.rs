//! Numbers on the command line.

/// A part of a whole that leaves something of it.
pub(super) fn share(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(share) if 0.0 < share && share < 1.0 => Ok(share),
        Ok(_) => Err("expected a number between 0 and 1, both excluded".to_owned()),
        Err(error) => Err(format!("expected a number between 0 and 1: {error}")),
    }
}

/// A number above zero.
pub(super) fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if 0.0 < number && number.is_finite() => Ok(number),
        _ => Err("expected a number above 0".to_owned()),
    }
}
