//! Messages over the server: names of streams and subjects, headers, and reports.

use super::job::Done;
use async_nats::HeaderMap;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// Version of the message format. Messages of other formats are rejected with an error that names the version.
pub(super) const FORMAT: &str = "3";

pub(super) const CASES: &str = "HIL_CASES";
/// Stream of results, until they are stored.
pub(super) const RESULTS: &str = "HIL_RESULTS";
pub(super) const LEASES: &str = "HIL_LEASES";
/// Object store of packages, failing cases and results of campaigns.
pub(super) const OBJECTS: &str = "HIL";

/// Headers common to all formats, so that other formats can be recognised.
mod header {
    pub const FORMAT: &str = "Hil-Format";
    pub const VERSION: &str = "Hil-Version";
    pub const CAMPAIGN: &str = "Hil-Campaign";
    pub const PACKAGE: &str = "Hil-Package";
    pub const LEASE: &str = "Hil-Lease";
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Place {
    /// In virtual time, on any machine.
    Virtual,
    Bench(String),
}

impl Place {
    /// The bench with this name: letters, digits, `-` and `_`, which are valid in any NATS subject.
    pub fn bench(name: &str) -> Option<Self> {
        let fits = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
        (!name.is_empty() && name.len() <= 64 && name.chars().all(fits))
            .then(|| Self::Bench(name.to_owned()))
    }

    /// Subject of all cases at this place for workers of this version.
    pub(super) fn cases(&self, version: &str) -> String {
        format!("{}.{}.>", self.subject(), word(version))
    }

    pub(super) fn case(&self, version: &str, campaign: &str, id: &str) -> String {
        format!("{}.{}.{campaign}.{id}", self.subject(), word(version))
    }

    pub(super) fn campaign(&self, campaign: &str) -> String {
        format!("{}.*.{campaign}.>", self.subject())
    }

    fn subject(&self) -> String {
        match self {
            Self::Virtual => "hil.cases.virtual".to_owned(),
            Self::Bench(name) => format!("hil.cases.bench.{name}"),
        }
    }

    /// Name of the consumer that all workers of this version at this place share.
    pub(super) fn consumer(&self, version: &str) -> String {
        match self {
            Self::Virtual => format!("virtual-{}", word(version)),
            Self::Bench(name) => format!("bench-{name}-{}", word(version)),
        }
    }
}

/// A version in the form of a subject token.
fn word(version: &str) -> String {
    version.replace(|c: char| !c.is_ascii_alphanumeric(), "-")
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Virtual => f.write_str("virtual time"),
            Self::Bench(name) => write!(f, "bench {name}"),
        }
    }
}

pub(super) fn result_subject(campaign: &str, id: &str) -> String {
    format!("hil.results.{campaign}.{id}")
}

pub(super) fn results_subject(campaign: &str) -> String {
    format!("hil.results.{campaign}.>")
}

/// Sender of a message: version, campaign, package and lease.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Said {
    pub(super) version: String,
    pub(super) campaign: String,
    pub(super) package: String,
    /// Number of the lease under which the coordinator sent it, unique to an attempt.
    pub(super) lease: u64,
}

/// A sender of another version.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Other {
    pub(super) version: String,
    pub(super) campaign: String,
}

impl Said {
    pub(super) fn headers(&self) -> HeaderMap {
        let mut headers = HeaderMap::new();
        headers.insert(header::FORMAT, FORMAT);
        headers.insert(header::VERSION, self.version.as_str());
        headers.insert(header::CAMPAIGN, self.campaign.as_str());
        headers.insert(header::PACKAGE, self.package.as_str());
        headers.insert(header::LEASE, self.lease.to_string());
        headers
    }

    /// Parses the headers of a message, if it has this `version` and format.
    pub(super) fn of(headers: Option<&HeaderMap>, version: &str) -> Result<Self, Other> {
        let text = |name| {
            let value = headers.and_then(|headers| headers.get(name));
            value.map_or("", |value| value.as_str()).to_owned()
        };
        let campaign = text(header::CAMPAIGN);
        match (text(header::VERSION), text(header::FORMAT).as_str()) {
            (theirs, FORMAT) if theirs == version => {
                let lease = text(header::LEASE).parse().unwrap_or_default();
                Ok(Self { version: theirs, campaign, package: text(header::PACKAGE), lease })
            }
            (theirs, format) => {
                let version =
                    format!("{} (message format {})", or_unknown(&theirs), or_unknown(format));
                Err(Other { version, campaign })
            }
        }
    }
}

fn or_unknown(text: &str) -> &str {
    if text.is_empty() { "unknown" } else { text }
}

/// A worker's report on a case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Report {
    pub(super) worker: String,
    pub(super) came: Came,
}

/// Result of a job.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Came {
    Done(Box<Done>),
    /// This worker cannot carry out any job of the campaign.
    Refused(String),
}

pub(super) fn id_of(subject: &str) -> &str {
    subject.rsplit('.').next().unwrap_or_default()
}

impl FromStr for Place {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::bench(text).ok_or_else(|| {
            format!("`{text}`: the name of a bench is of letters, digits, - and _, 64 at most")
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::job::Job;
    use super::{Came, FORMAT, Place, Report, Said, id_of};
    use campaign::toy::{Toy, space};
    use campaign::{Random, Search as _};
    use proptest::prelude::*;

    fn said() -> Said {
        let text = str::to_owned;
        Said { version: text("0.1.0"), campaign: text("c0ffee"), package: text("abcd"), lease: 42 }
    }

    #[test]
    fn who_is_of_another_version_is_named() {
        let headers = said().headers();
        assert_eq!(Said::of(Some(&headers), "0.1.0"), Ok(said()));
        let other = Said::of(Some(&headers), "0.2.0").unwrap_err();
        assert_eq!(
            (other.version.as_str(), other.campaign.as_str()),
            ("0.1.0 (message format 3)", "c0ffee")
        );
        let mut headers = said().headers();
        headers.insert("Hil-Format", "99");
        let other = Said::of(Some(&headers), "0.1.0").unwrap_err();
        assert_eq!(other.version, "0.1.0 (message format 99)");
        let other = Said::of(None, "0.1.0").unwrap_err();
        assert_eq!(other.version, "unknown (message format unknown)");
        assert_eq!(FORMAT, "3");
    }

    #[test]
    fn subjects() {
        let bench = Place::bench("by-the-window").unwrap();
        let subject = bench.case("0.1.0+ab12", "c0ffee", "01ab");
        assert_eq!(subject, "hil.cases.bench.by-the-window.0-1-0-ab12.c0ffee.01ab");
        assert_eq!(bench.consumer("0.1.0+ab12"), "bench-by-the-window-0-1-0-ab12");
        assert_eq!(id_of(&subject), "01ab");
        let subject = Place::Virtual.case("0.1.0", "c0ffee", "01ab");
        assert_eq!(subject, "hil.cases.virtual.0-1-0.c0ffee.01ab");
        assert_eq!(Place::Virtual.cases("0.1.0"), "hil.cases.virtual.0-1-0.>");
        assert_eq!(Place::Virtual.campaign("c0ffee"), "hil.cases.virtual.*.c0ffee.>");
        for bad in ["", "a.b", "a b", "*", ">"] {
            assert!(bad.parse::<Place>().is_err(), "{bad}");
        }
    }

    #[test]
    fn jobs_and_results_are_what_they_were() {
        let mut random = Random::new(&space(), 7);
        for _ in 0..200 {
            let case = random.next();
            let job = Job::Case(case);
            assert_eq!(serde_json::from_slice::<Job>(&job.body()).unwrap(), job);
            let came = Came::Done(Box::new(job.carry_out(&Toy::default())));
            let report = Report { worker: "one".to_owned(), came };
            let there = serde_json::to_vec(&report).unwrap();
            assert_eq!(serde_json::from_slice::<Report>(&there).unwrap(), report);
        }
    }

    proptest! {
        #[test]
        fn no_bytes_make_it_panic(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
            let _ = serde_json::from_slice::<Report>(&bytes);
            let _ = serde_json::from_slice::<Job>(&bytes);
            let _ = super::super::Package::of_json(&bytes);
            let _ = id_of(&String::from_utf8_lossy(&bytes));
        }
    }
}
