mod blf;
mod damaged;
mod messages;
mod round_trip;
mod samples;
