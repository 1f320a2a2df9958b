//! Beginnings, segments and the record of a proposed plant file.

use super::mechanism::{Axis, Mechanism, axis_of};
use super::names::plain;
use super::parts::Reading;
use super::roles::{Guess, Role};
use super::samples::rates;
use crate::plant::words::digits;
use channels::{Channel, Recording};
use std::fmt::Write;

/// `[initial]` or segments, and `[simulation]`.
pub fn closing(mechanism: &Mechanism, guesses: &[Guess], parts: &[Recording], text: &mut String) {
    let (period_s, length_s) = rates(parts);
    let scope = if parts.len() == 1 { "per recording" } else { "per segment" };
    let begins = |part: &Recording| beginnings(mechanism, guesses, part, scope);
    if let [part] = parts {
        let lines: String = begins(part).iter().map(|line| format!("{line}\n")).collect();
        if !lines.is_empty() {
            let _ = write!(text, "\n[initial] # the first samples\n{lines}");
        }
    } else {
        let mut at_s = 0.0;
        for (i, part) in parts.iter().enumerate() {
            let end_s = at_s + rates(std::slice::from_ref(part)).1;
            let lines = begins(part).join(", ");
            let initial = if lines.is_empty() { String::new() } else { format!("initial = {{ {lines} }}\n") };
            let why = if i == 0 { "" } else { " # time begins again here in the recording" };
            let _ = write!(
                text,
                "\n[[segment]]{why}\nname = \"part_of_record_{}\"\nbegin = \"{} s\"\nend = \"{} s\"\n{initial}",
                i + 1,
                digits(at_s, 9),
                digits(end_s, 9)
            );
            at_s = end_s;
        }
    }
    if mechanism.vertical() {
        let _ = write!(text, "\n# y points upwards, along which gravity acts\n");
    }
    let _ = write!(
        text,
        "\n[simulation] # from the time column\nduration = \"{} s\"\nperiod = \"{} s\"\n",
        digits(length_s, 9),
        digits(period_s, 9)
    );
}

/// Where each coordinate begins, as far as channels tell.
fn beginnings(mechanism: &Mechanism, guesses: &[Guess], part: &Recording, scope: &str) -> Vec<String> {
    let with = |role: Role| {
        let of = part.channels.iter().zip(guesses);
        of.filter(move |(_, guess)| guess.role == role).map(|(channel, _)| channel)
    };
    if mechanism.free {
        // a rate about one axis is a rate of the body; in a plane all are about z
        let axis = |channel: &Channel| if mechanism.spatial { axis_of(&channel.name) } else { Some("z") };
        let mut seen = Vec::new();
        return with(Role::AngleRate)
            .filter_map(|channel| {
                let axis = axis(channel).filter(|axis| !seen.contains(axis))?;
                seen.push(axis);
                if let Some(bearing) = mechanism.bearing {
                    let turned = (axis == bearing).then(|| first(channel, scope)).flatten()?;
                    return Some(format!("\"joint:bearing\" = {{ rate = {turned} }}"));
                }
                Some(format!("\"body:body.r{axis}\" = {{ rate = {} }}", first(channel, scope)?))
            })
            .collect();
    }
    let imposed = guesses.iter().any(|guess| guess.role == Role::Imposed);
    let axes = mechanism.axes.iter().filter(|_| !imposed);
    axes.filter_map(|axis| beginning(axis, mechanism, &part.channels, guesses, scope)).collect()
}

fn beginning(
    axis: &Axis,
    mechanism: &Mechanism,
    channels: &[Channel],
    guesses: &[Guess],
    scope: &str,
) -> Option<String> {
    let (unit, rate_unit) = if axis.linear { ("m", "m/s") } else { ("rad", "rad/s") };
    let of_axis = channels.iter().find(|channel| format!("joint_{}", plain(&channel.name)) == axis.name)?;
    let is_rate = |guess: &Guess| matches!(guess.role, Role::AngleRate | Role::Velocity);
    let reads_rate = |(channel, guess): &(&Channel, &Guess)| {
        is_rate(guess) && mechanism.joint(channel, axis.linear).is_some_and(|joint| joint.name == axis.name)
    };
    let rate_channel = channels.iter().zip(guesses).find(reads_rate).map(|(channel, _)| channel);
    let position = (of_axis.unit == unit).then(|| first(of_axis, scope)).flatten();
    let rate = rate_channel.and_then(|channel| first(channel, scope)).or_else(|| {
        let sigma = digits(speed(of_axis), 2);
        position.as_ref().map(|_| format!("{{ value = 0, sigma = \"{sigma} {rate_unit}\", scope = \"{scope}\" }}"))
    });
    let stated = [("position", position), ("rate", rate)];
    let stated: Vec<String> = stated.into_iter().filter_map(|(key, text)| Some(format!("{key} = {}", text?))).collect();
    (!stated.is_empty()).then(|| format!("\"joint:{}\" = {{ {} }}", axis.name, stated.join(", ")))
}

/// The first sample, with what its sensor may be off.
fn first(channel: &Channel, scope: &str) -> Option<String> {
    let (value, unit) = (digits(*channel.value.first()?, 4), channel.unit.as_str());
    let Reading { sigma, bias, .. } = Reading::of(&channel.value, unit);
    let sigma = digits(3.0 * sigma.max(bias), 2);
    Some(format!("{{ value = \"{value} {unit}\", sigma = \"{sigma} {unit}\", scope = \"{scope}\" }}"))
}

/// Root mean square of a channel's slope: what its rate may have been at any time.
fn speed(channel: &Channel) -> f64 {
    let steps = channel.value.windows(2).zip(channel.time_s.windows(2));
    let slopes =
        steps.map(|(value, time)| (value[1] - value[0]) / (time[1] - time[0])).filter(|slope| slope.is_finite());
    let (count, squares) = slopes.fold((0.0, 0.0), |(count, squares), slope| (count + 1.0, squares + slope * slope));
    if squares > 0.0 { (squares / count).sqrt() } else { 1.0 }
}
