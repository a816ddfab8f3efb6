mod distance;
mod oracle;
mod refusals;
mod seams;
mod sweep;
mod touch;
