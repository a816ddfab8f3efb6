mod distance;
mod extremes;
mod oracle;
mod refusals;
mod seams;
mod sweep;
mod touch;
