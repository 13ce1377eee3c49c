#include "sightline/report/page.hpp"

#include <fmt/format.h>

namespace sightline {
namespace {

constexpr std::string_view page_style = R"(
:root { color-scheme: light dark; --line: #8a8f9855; --paper: #fff; --ink: #1b1f24; --soft: #5c6570; --warn: #c2410c; }
@media screen and (prefers-color-scheme: dark) {
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
figure { margin: 0; break-inside: avoid; }
h2 { break-after: avoid; }
svg { display: block; width: 100%; height: auto; }
.panels { display: grid; align-items: end; }
.axes { position: relative; }
.axes > svg { touch-action: pan-y; user-select: none; }
.legend { display: flex; flex-wrap: wrap; gap: 0 0.75rem; padding-left: 11%; }
.legend button { display: flex; align-items: center; gap: 0.4rem; border: 0; padding: 0; background: none; color: inherit;
  font: inherit; font-size: 0.85rem; cursor: pointer; }
.legend button[aria-pressed="false"] { opacity: 0.35; }
.legend svg { width: 26px; }
.hint { margin-top: 1.5rem; }
.tip { position: absolute; top: 4px; z-index: 1; padding: 0 0.4rem; border-radius: 4px; background: var(--paper); font-size: 0.8rem;
  border: 1px solid var(--line); pointer-events: none; white-space: nowrap; }
.tip i { display: inline-block; width: 0.6rem; height: 0.6rem; margin-right: 0.3rem; }
details { margin-top: 2.5rem; }
pre { overflow-x: auto; font-size: 0.85rem; border: 1px solid var(--line); padding: 1rem; border-radius: 6px; }
@media print { :root { color-scheme: light; } body { max-width: none; padding: 0; } .hint, .tip, .hover { display: none; } }
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
      "<style>{1}</style>\n</head>\n<body>\n<h1>{0}</h1>\n{2}",
      escaped(title), page_style,
      figures_script().empty()
          ? "<p class=\"warning\">Most figures are missing: this sightline was built without esbuild, which "
            "scripts/deps.sh demo installs.</p>\n"
          : "<noscript><p class=\"warning\">Most figures need JavaScript.</p></noscript>\n");
}

namespace {

std::string framed(std::string_view title, std::string_view caption, std::string_view content) {
  return fmt::format(
      "<h2>{0}</h2>\n<figure aria-label=\"{0}\">\n{1}\n<figcaption>{2}</figcaption>\n</figure>\n",
      escaped(title), content, escaped(caption));
}

}  // namespace

std::string page_figure(const Figure& figure) { return framed(figure.title, figure.caption, figure.svg); }

std::string page_figures(std::vector<Drawing> drawings) {
  prune(drawings);
  std::string page;
  for (const Drawing& drawing : drawings) {
    page += framed(drawing.title, drawing.caption,
                   fmt::format("<script type=\"application/json\">{}</script>", to_json(drawing)));
  }
  return page;
}

std::string page_end() { return fmt::format("<script>{}</script>\n</body>\n</html>\n", figures_script()); }

}  // namespace sightline
