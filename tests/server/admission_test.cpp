#include "sightline/server/admission.hpp"

#include <gtest/gtest.h>

#include <set>

namespace sightline {
namespace {

constexpr std::uint16_t port_of_page = 8765;

HttpRequest requesting(std::string host, std::string origin = "", std::string query = "") {
  HttpRequest request{"GET", "/live", std::move(query)};
  request.headers["host"] = std::move(host);
  if (!origin.empty()) request.headers["origin"] = std::move(origin);
  return request;
}

TEST(Admission, OnLoopbackItsOwnNamesAreHostsAndNoOther) {
  const Admission admission(port_of_page, "");
  for (const char* host : {"127.0.0.1:8765", "localhost:8765"})
    EXPECT_EQ(admission.refusal(requesting(host)), "") << host;
  // The last ones as a name that is turned to 127.0.0.1 says it.
  for (const char* host :
       {"", "127.0.0.1", "localhost", "127.0.0.1:8764", "192.168.0.2:8765", "localhost.:8765",
        "attacker.example:8765", "127.0.0.1.attacker.example:8765", "localhost:8765:8765"})
    EXPECT_NE(admission.refusal(requesting(host)), "") << host;
}

TEST(Admission, APageOfAnotherOriginIsRefused) {
  const Admission admission(port_of_page, "");
  EXPECT_EQ(admission.refusal(requesting("localhost:8765", "http://localhost:8765")), "");
  for (const char* origin :
       {"null", "http://attacker.example", "https://localhost:8765", "http://localhost:8766",
        "http://127.0.0.1:8765", "http://localhost:8765.attacker.example"})
    EXPECT_NE(admission.refusal(requesting("localhost:8765", origin)), "") << origin;
}

TEST(Admission, AllowedOriginsMayAskForTopicsAndNothingElse) {
  const Admission admission(port_of_page, "", {"https://app.foxglove.dev", "file://"});
  for (const char* origin : {"", "http://localhost:8765", "https://app.foxglove.dev", "file://"})
    EXPECT_EQ(admission.refusal(requesting("localhost:8765", origin), Admission::Requested::topics), "")
        << origin;
  for (const char* origin : {"null", "http://app.foxglove.dev", "https://app.foxglove.dev.attacker.example"})
    EXPECT_NE(admission.refusal(requesting("localhost:8765", origin), Admission::Requested::topics), "")
        << origin;
  for (const auto requested : {Admission::Requested::flight, Admission::Requested::open_file})
    EXPECT_NE(admission.refusal(requesting("localhost:8765", "https://app.foxglove.dev"), requested), "");
  EXPECT_NE(admission.refusal(requesting("attacker.example:8765", "https://app.foxglove.dev"),
                              Admission::Requested::topics),
            "");
}

TEST(Admission, AnOriginIsOneOfAPageThatOtherPagesCannotSay) {
  for (const char* origin :
       {"https://app.foxglove.dev", "http://localhost:8080", "http://[::1]:3", "file://"})
    EXPECT_NO_THROW(check_origin(origin)) << origin;
  for (const char* origin : {"", "null", "*", "app.foxglove.dev", "https://", "https://app.foxglove.dev/",
                             "https://APP.foxglove.dev", "file:///home", "https://a b"})
    EXPECT_THROW(check_origin(origin), std::invalid_argument) << origin;
}

TEST(Admission, ToOthersTheTokenIsAskedForOfAllThatIsOfTheFlight) {
  const std::string token = random_token();
  const Admission admission(port_of_page, token);
  const auto with = [&](const std::string& query) { return requesting("192.168.0.2:8765", "", query); };
  EXPECT_EQ(admission.refusal(with("token=" + token)), "");
  EXPECT_EQ(admission.refusal(with(""), Admission::Requested::open_file), "");
  std::string other = token;
  other.back() = other.back() == '0' ? '1' : '0';
  for (const std::string& query : {std::string(), std::string("token="), "token=" + other,
                                   "token=" + token + "0", "token=" + token.substr(1), "tokens=" + token})
    EXPECT_NE(admission.refusal(with(query)), "") << query;
  // A token does not make a name a host.
  EXPECT_NE(admission.refusal(requesting("attacker.example:8765", "", "token=" + token)), "");
}

TEST(Admission, TokensHave192BitsAndAreNotTheSame) {
  std::set<std::string> tokens;
  for (int i = 0; i < 100; ++i) tokens.insert(random_token());
  EXPECT_EQ(tokens.size(), 100U);
  for (const std::string& token : tokens) {
    EXPECT_EQ(token.size(), 48U);
    EXPECT_EQ(token.find_first_not_of("0123456789abcdef"), std::string::npos);
  }
}

TEST(Admission, SecretsAreTheSameInAllTheirBytesAlone) {
  EXPECT_TRUE(same_secret("abc", "abc"));
  EXPECT_TRUE(same_secret("", ""));
  for (const char* given : {"", "a", "ab", "abd", "abcd", "abcabc", "xbc"})
    EXPECT_FALSE(same_secret(given, "abc"));
  EXPECT_FALSE(same_secret("a", ""));
}

}  // namespace
}  // namespace sightline
