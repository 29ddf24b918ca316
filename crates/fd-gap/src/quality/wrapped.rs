//! Angles that begin anew after a turn, and of which nobody says so.

use fd_model::{Channel, unit::turn};

/// How often a signal jumps by more than half a turn from one sample to the next and stays there, without ever leaving the one
/// turn that it has; none where it is no angle, or is declared as one that wraps.
///
/// *When not to use:* on an angle that moves by half a turn in a sample; nothing tells where it went.
pub(super) fn jumps(channel: &Channel, signal: &[f64]) -> usize {
    let Some(turn) = turn(&channel.unit).filter(|_| !channel.wraps) else { return 0 };
    let seen: Vec<f64> = signal.iter().copied().filter(|v| v.is_finite()).collect();
    let range = |[low, high]: [f64; 2], v: &f64| [low.min(*v), high.max(*v)];
    let [low, high] = seen.iter().fold([f64::INFINITY, f64::NEG_INFINITY], range);
    if turn < high - low {
        return 0;
    }
    let is_far = |a: f64, b: f64| 0.5 * turn < (a - b).abs();
    seen.windows(3).filter(|w| is_far(w[0], w[1]) && is_far(w[0], w[2])).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turn_is_a_jump_and_a_spike_is_none() {
        let angle = Channel::new("heading", "deg");
        let turning: Vec<f64> = (0..100).map(|k| f64::from(37 * k % 360) - 180.0).collect();
        // 37 degrees a sample are ten turns in 99 steps.
        assert_eq!(jumps(&angle, &turning), 10);
        assert_eq!(jumps(&angle.clone().wrapping(true), &turning), 0);
        assert_eq!(jumps(&Channel::new("force", "N"), &turning), 0);
        let mut spike = vec![3.0; 20];
        spike[7] = -179.0;
        spike[8] = 200.0;
        assert_eq!(jumps(&angle, &spike), 0);
        // What goes on does not begin anew.
        let on: Vec<f64> = (0..100).map(|k| f64::from(37 * k)).collect();
        assert_eq!(jumps(&angle, &on), 0);
    }
}
