//! What people look at: plots, one offline HTML file, the terminal.
