#include "sightline/report/page.hpp"

#include <fmt/format.h>

namespace sightline {
namespace {

constexpr std::string_view page_style = R"(
:root { color-scheme: light dark; --line: #8a8f9855; --paper: #fff; --ink: #1b1f24; --soft: #5c6570; --warn: #c2410c; }
@media (prefers-color-scheme: dark) {
  :root { --paper: #15181c; --ink: #e6e8eb; --soft: #9aa3ad; --warn: #fb923c; }
}
body { background: var(--paper); color: var(--ink); font: 16px/1.5 system-ui, sans-serif; max-width: 940px;
  margin: 0 auto; padding: 2rem 1.25rem 4rem; }
h1 { font-size: 1.7rem; margin: 0; }
h2 { font-size: 1.15rem; margin: 2.5rem 0 0.75rem; }
p { margin: 0.25rem 0; }
.soft, figcaption { color: var(--soft); font-size: 0.9rem; }
.warning { color: var(--warn); font-weight: 600; margin: 1rem 0; }
table { border-collapse: collapse; width: 100%; }
th, td { border-bottom: 1px solid var(--line); padding: 0.35rem 0.75rem 0.35rem 0; text-align: left;
  vertical-align: top; overflow-wrap: anywhere; }
th { font-weight: 500; color: var(--soft); width: 32%; }
figure { margin: 0; }
svg { display: block; width: 100%; height: auto; }
details { margin-top: 2.5rem; }
pre { overflow-x: auto; font-size: 0.85rem; border: 1px solid var(--line); padding: 1rem; border-radius: 6px; }
)";

}  // namespace

std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : text) {
    if (c == '&')
      result += "&amp;";
    else if (c == '<')
      result += "&lt;";
    else if (c == '>')
      result += "&gt;";
    else if (c == '"')
      result += "&quot;";
    else if (static_cast<unsigned char>(c) < ' ' && c != '\n' && c != '\t')
      result += ' ';
    else
      result += c;
  }
  return result;
}

std::string page_head(std::string_view title) {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{0}</title>\n"
      "<style>{1}</style>\n</head>\n<body>\n<h1>{0}</h1>\n",
      escaped(title), page_style);
}

std::string page_figure(const Figure& figure) {
  return fmt::format(
      "<h2>{0}</h2>\n<figure aria-label=\"{0}\">\n{1}\n<figcaption>{2}</figcaption>\n</figure>\n",
      escaped(figure.title), figure.svg, escaped(figure.caption));
}

}  // namespace sightline
