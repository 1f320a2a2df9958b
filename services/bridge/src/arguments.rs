//! The command line of `obsid-bridge`; `obsid bridge --help` explains it.

use crate::BridgeError;
use crate::wire;
use std::path::PathBuf;
use telemetry::{TOPICS, TopicId, is_carried, topic_named};

/// Samples of a stream that are kept until acknowledged: four minutes of an estimate a second.
const ROOM: usize = 256;

/// Which end of the line this is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum End {
    /// Waits at this endpoint.
    Listen(String),
    /// Goes to that endpoint.
    Connect(String),
}

/// What a bridge does.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Arguments {
    pub end: End,
    /// Folder of the run whose samples are sent.
    pub run: Option<PathBuf>,
    /// Folder in which the other computer's run appears.
    pub mirror: Option<PathBuf>,
    /// What is sent.
    pub topics: Vec<TopicId>,
    /// Samples of a stream that wait for an acknowledgement.
    pub room: usize,
}

/// Reads `--name value` pairs.
///
/// # Errors
/// [`BridgeError::Usage`] with what is wrong and what there is.
pub fn parse(arguments: &[String]) -> Result<Arguments, BridgeError> {
    let wrong = |what: String| Err(BridgeError::Usage(what));
    let (mut end, mut run, mut mirror) = (None, None, None);
    let (mut topics, mut room) = (wire::default_topics(), ROOM);
    for pair in arguments.chunks(2) {
        let [name, value] = pair else { return wrong(format!("{}: a value is missing", pair[0])) };
        match name.as_str() {
            "--listen" | "--connect" if end.is_some() => return wrong("one of --listen and --connect, once".into()),
            "--listen" => end = Some(End::Listen(value.clone())),
            "--connect" => end = Some(End::Connect(value.clone())),
            "--run" => run = Some(PathBuf::from(value)),
            "--mirror" => mirror = Some(PathBuf::from(value)),
            "--topics" => topics = value.split(',').map(topic).collect::<Result<_, _>>()?,
            "--room" => match value.parse() {
                Ok(samples) if samples > 0 => room = samples,
                _ => return wrong(format!("--room {value}: a number of samples above 0")),
            },
            _ => return wrong(format!("{name}: unknown; see `obsid bridge --help`")),
        }
    }
    let Some(end) = end else { return wrong("--listen ENDPOINT or --connect ENDPOINT is missing".into()) };
    if run.is_none() && mirror.is_none() {
        return wrong(
            "--run FOLDER (what is sent) or --mirror FOLDER (where the other's run appears) is missing".into(),
        );
    }
    if let (Some(run), Some(mirror)) = (&run, &mirror)
        && run.parent() == mirror.parent()
    {
        let cure = "give the mirror another parent, or `obsid events` takes it for the newest run";
        return wrong(format!("--mirror {}: lies beside the run; {cure}", mirror.display()));
    }
    Ok(Arguments { end, run, mirror, topics, room })
}

fn topic(name: &str) -> Result<TopicId, BridgeError> {
    let carried = || {
        let names = TOPICS.iter().enumerate().filter(|(topic, _)| is_carried(*topic)).map(|(_, info)| info.name);
        names.collect::<Vec<_>>().join(", ")
    };
    topic_named(name).filter(|&topic| is_carried(topic)).ok_or_else(|| {
        BridgeError::Usage(format!("--topics {name}: no topic that is carried; there are {}", carried()))
    })
}

#[cfg(test)]
mod tests {
    use super::{Arguments, End, parse};
    use telemetry::{EVENT, VERDICT};

    fn parsed(line: &str) -> Result<Arguments, String> {
        parse(&line.split(' ').map(String::from).collect::<Vec<_>>()).map_err(|error| error.to_string())
    }

    #[test]
    fn a_line_is_read_and_what_is_wrong_in_one_is_said() {
        let arguments =
            parsed("--connect tcp/10.0.0.1:7447 --mirror /run/far --topics verdict,event --room 8").unwrap();
        assert_eq!(arguments.end, End::Connect("tcp/10.0.0.1:7447".into()));
        assert_eq!((arguments.topics, arguments.room), (vec![VERDICT.id, EVENT.id], 8));
        for (line, word) in [
            ("--mirror /run/far", "--listen"),
            ("--listen tcp/[::]:1", "--mirror"),
            ("--listen a --connect b --run r", "once"),
            ("--listen a --run r --topics imu", "estimate/slosh"),
            ("--listen a --run r --room 0", "above 0"),
            ("--listen a --run", "value is missing"),
            ("--loud a", "unknown"),
            ("--listen a --run /run/obsid/r --mirror /run/obsid/m", "another parent"),
        ] {
            assert!(parsed(line).unwrap_err().contains(word), "{line}");
        }
    }
}
