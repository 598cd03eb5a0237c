// In the book, a link to a file beside the documentation leads nowhere: its text alone stays.
"use strict";
document.querySelectorAll("main a[href]").forEach(link => {
  const address = link.getAttribute("href");
  const ups = text => text.split("/").filter(part => part === "..").length;
  if (!/^[a-z]+:/.test(address) && ups(address) > ups(path_to_root)) link.replaceWith(...link.childNodes);
});
