//! Long logs: stretches are fitted, all rows are judged.

use fd_gap::stretches::stretches;
use fd_model::Record;
use fd_sim::simulate::Nominal;

use super::{
    automatic::longest,
    data::{Data, Long},
    error::GapError,
    log_part::{LogPart, Role},
    memory::Memory,
};

/// Rows of all logs together from which stretches are fitted instead.
const LONG: usize = 20_000;
/// Rows of the stretches that models are fitted to …
const FITTED: usize = 5_000;
/// … and of those that are held out.
const HELD_OUT: usize = 2_500;
/// Shortest stretch, in rows.
const SHORTEST: usize = 500;
/// Length of a stretch in memories of the model: its states at the start are unknown.
const MEMORIES: f64 = 5.0;
/// Length, in rows, of a stretch of a model that does not forget its start.
const UNFORGETTING: usize = 1_250;
/// Rows along which the memory of the model is looked for.
const SEEN: usize = 10_000;

/// Puts the stretches that tell most in the place of logs that are long.
pub(super) fn shortened(mut data: Data, nominal: &dyn Nominal) -> Result<Data, GapError> {
    let records = data.fit.iter().chain(&data.held_out);
    if records.map(Record::len).sum::<usize>() <= LONG {
        return Ok(data);
    }
    let length = stretch(&data, nominal)?;
    let records = std::mem::take(&mut data.fit).into_iter();
    let records = records.chain(std::mem::take(&mut data.held_out));
    let parts: Vec<(LogPart, Record)> =
        std::mem::take(&mut data.parts).into_iter().zip(records).collect();
    let rows = |role: Role| -> usize {
        parts.iter().filter(|(part, _)| part.role == role).map(|(_, r)| r.len()).sum()
    };
    let all = [rows(Role::Fit), rows(Role::HeldOut)];
    for (part, record) in &parts {
        let (wanted, all) = match part.role {
            Role::Fit => (FITTED, all[0]),
            Role::HeldOut => (HELD_OUT, all[1]),
        };
        // In proportion to the length of each log.
        let count = (wanted * record.len()).div_ceil(all * length).max(1);
        for rows in stretches(record, length, count) {
            data.add(part, record, [rows.start, rows.end]);
        }
    }
    data.long = Some(Long { parts, length });
    Ok(data)
}

/// How long a stretch must be.
fn stretch(data: &Data, nominal: &dyn Nominal) -> Result<usize, GapError> {
    let Some(record) = data.fit.iter().max_by_key(|record| record.len()) else {
        return Ok(SHORTEST);
    };
    let simulator = nominal.simulator(record.ts())?;
    let log = fd_gap::fit::Log::new(&record.slice(0, SEEN), &*simulator, 1)?;
    let (u, samples) = longest(&[log]);
    let memory = Memory::of(&*simulator, &u, samples);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
    let memories = |seconds: f64| (MEMORIES * seconds / record.ts().seconds()).ceil() as usize;
    let forgotten = memory.seconds.map_or(SHORTEST, memories);
    let least = if memory.forgets { SHORTEST } else { UNFORGETTING };
    Ok(forgotten.clamp(least, FITTED))
}
