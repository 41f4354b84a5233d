mod blf;
mod damaged;
mod mdf4;
mod messages;
mod round_trip;
mod samples;
