// SPDX-License-Identifier: Apache-2.0
#include "events/payloads.hpp"

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

namespace lcrig {

namespace {

using nlohmann::json;

constexpr double kLargest = std::numeric_limits<double>::max();

std::string quoted(std::string_view text) {
  return json(text).dump(-1, ' ', false, json::error_handler_t::replace);
}

// Writes fields in the order of the calls, and leaves out absent ones.
class PayloadWriter {
 public:
  // An infinite number, which JSON does not have, becomes a large one.
  void field(const char* key, double v) {
    put(key, fmt::format("{}", std::clamp(v, -kLargest, kLargest)));
  }
  void field(const char* key, std::int64_t v) { put(key, fmt::format("{}", v)); }
  void field(const char* key, bool v) { put(key, v ? "true" : "false"); }
  void field(const char* key, std::string_view v) { put(key, quoted(v)); }
  void field(const char* key, const std::vector<std::string>& v) {
    put(key, json(v).dump(-1, ' ', false, json::error_handler_t::replace));
  }
  // An infinite number becomes null.
  void field(const char* key, const std::vector<double>& v) { put(key, json(v).dump()); }
  template <HasWords E>
  void field(const char* key, E v) {
    field(key, to_string(v));
  }
  template <class T>
  void field(const char* key, const std::optional<T>& v) {
    if (v) field(key, *v);
  }
  void or_null(const char* key, const std::optional<double>& v) {
    put(key, v ? fmt::format("{}", *v) : "null");
  }
  void milli(const char* key, double v) { put(key, fmt::format("{:.3f}", v)); }
  // Writes numbers as the JSON library does: 1.0, not 1.
  void decimal(const char* key, const std::optional<double>& v) {
    if (v) put(key, json(*v).dump());
  }
  std::string text() const { return "{" + text_ + "}"; }

 private:
  void put(const char* key, std::string_view value) {
    text_ += fmt::format(R"({}"{}":{})", text_.empty() ? "" : ",", key, value);
  }
  std::string text_;
};

class PayloadReader {
 public:
  explicit PayloadReader(const json& from) : from_(from) {}

  template <class T>
  void field(const char* key, T& v) {
    if (!take(key, v) && !missing_) missing_ = key;
  }
  template <class T>
  void field(const char* key, std::optional<T>& v) {
    if (T got{}; take(key, got)) v = std::move(got);
  }
  void or_null(const char* key, std::optional<double>& v) { field(key, v); }
  void milli(const char* key, double& v) { field(key, v); }
  void decimal(const char* key, std::optional<double>& v) { field(key, v); }
  const char* missing() const { return missing_; }

 private:
  template <class T>
  bool take(const char* key, T& v) const {
    const auto it = from_.find(key);
    if (it == from_.end() || !is(*it, v)) return false;
    v = it->get<T>();
    return true;
  }
  bool take(const char* key, std::vector<double>& v) const {
    const auto it = from_.find(key);
    if (it == from_.end() || !is(*it, v)) return false;
    v.clear();
    for (const json& e : *it) {
      v.push_back(e.is_null() ? std::numeric_limits<double>::infinity() : e.get<double>());
    }
    return true;
  }
  template <HasWords E>
  bool take(const char* key, E& v) const {
    std::string word;
    const auto known = take(key, word) ? parse_word<E>(word) : std::nullopt;
    v = known.value_or(v);
    return known.has_value();
  }
  static bool is(const json& j, double) { return j.is_number(); }
  static bool is(const json& j, std::int64_t) { return j.is_number_integer(); }
  static bool is(const json& j, bool) { return j.is_boolean(); }
  static bool is(const json& j, const std::string&) { return j.is_string(); }
  static bool is(const json& j, const std::vector<double>&) {
    return j.is_array() &&
           std::ranges::all_of(j, [](const json& e) { return e.is_number() || e.is_null(); });
  }
  static bool is(const json& j, const std::vector<std::string>&) {
    return j.is_array() && std::ranges::all_of(j, [](const json& e) { return e.is_string(); });
  }

  const json& from_;
  const char* missing_ = nullptr;
};

template <class F, EventKind kind>
void fields(F& f, MotionEnded<kind>& e) {
  f.field("reason", e.reason);
  f.field("force_N", e.force_N);
  f.field("travel_m", e.travel_m);
}
template <class F, EventKind kind>
void fields(F& f, Touch<kind>& e) {
  f.field("travel_m", e.travel_m);
  f.field("force_N", e.force_N);
  f.field("rest_force_N", e.rest_force_N);
}
template <class F, EventKind kind>
void fields(F& f, LookAtRest<kind>& e) {
  f.field("force_N", e.force_N);
  f.field("scatter_N", e.scatter_N);
  f.field("samples", e.samples);
  f.field("travel_m", e.travel_m);
}
template <class F, EventKind kind>
void fields(F& f, OvershootOf<kind>& e) {
  f.field("threshold_N", e.threshold_N);
  f.field("predicted_N", e.predicted_N);
  f.or_null("expected_N", e.expected_N);
  f.field("observed_N", e.observed_N);
}
template <class F, EventKind kind>
void fields(F& f, Absence<kind>& e) {
  f.field("instrument", e.instrument);
  f.milli("seconds", e.seconds);
  f.milli("away_s", e.away_s);
  f.field("attempts", e.attempts);
}
template <class F>
void fields(F& f, StiffnessEvent& e) {
  f.field("force_N", e.force_N);
  f.or_null("stiffness_N_m", e.stiffness_N_m);
  f.or_null("at_most_N_m", e.at_most_N_m);
  f.or_null("at_least_N_m", e.at_least_N_m);
}
template <class F>
void fields(F& f, ZeroEvent& e) {
  f.field("force_before_N", e.force_before_N);
}
template <class F>
void fields(F& f, GapStatedEvent& e) {
  f.field("contact_travel_m", e.contact_travel_m);
}
template <class F>
void fields(F& f, ClockStepEvent& e) {
  f.milli("seconds", e.seconds);
}
template <class F>
void fields(F& f, LateSamplesEvent& e) {
  f.milli("age_s", e.age_s);
}
template <class F>
void fields(F& f, LevelAbandonedEvent& e) {
  f.field("level", e.level);
  f.field("readings", e.readings);
}
template <class F>
void fields(F& f, ContinuesEvent& e) {
  f.field("run", e.run);
  f.field("step", e.step);
  f.field("steps_done", e.steps_done);
}
template <class F>
void fields(F& f, SettingsEvent& e) {
  f.field("function", e.function);
  f.field("frequency_Hz", e.frequency_Hz);
  f.field("level_V", e.level_V);
  f.or_null("bias_V", e.bias_V);
  f.field("aperture", e.aperture);
  f.field("average", e.average);
  f.field("trigger", e.trigger);
  f.field("conversion_time_s", e.conversion_time_s);
}
template <class F>
void fields(F& f, ReadBackEvent& e) {
  f.field("equal", e.equal);
  f.field("differs", e.differs);
}
template <class F>
void fields(F& f, UnprovenEvent& e) {
  f.field("asked_from_mono_ns", e.asked_from_mono_ns);
  f.field("asked_to_mono_ns", e.asked_to_mono_ns);
  f.field("readings", e.readings);
  f.field("why", e.why);
}
template <class F>
void fields(F& f, RunPoint& e) {
  f.decimal("contact_travel_m", e.contact_travel_m);
  f.field("level_in_repeat", e.level_in_repeat);
  f.field("level_repeat", e.level_repeat);
  f.field("levels", e.levels);
  f.field("origin", e.origin);
  f.field("steps_done", e.steps_done);
  f.decimal("travel_m", e.travel_m);
  f.field("zeroed", e.zeroed);
  f.field("zeros_N", e.zeros_N);
}
template <class F>
void fields(F& f, WatchSetupEvent& e) {
  f.field("format", e.format);
  f.field("commands", e.commands);
  f.field("rate_Hz", e.rate_Hz);
  f.field("force_min_N", e.force_min_N);
  f.field("force_max_N", e.force_max_N);
  f.field("travel_min_m", e.travel_min_m);
  f.field("travel_max_m", e.travel_max_m);
  f.field("gap_min_m", e.gap_min_m);
  f.field("gap_max_m", e.gap_max_m);
  f.field("speed_max_m_s", e.speed_max_m_s);
  f.field("cell_class_percent", e.cell_class_percent);
  f.field("at_most_N_m", e.at_most_N_m);
  f.field("expected_N_m", e.expected_N_m);
  f.field("if_free_N_m", e.if_free_N_m);
}
template <class F>
void fields(F& f, WatchInputEvent& e) {
  f.field("what", e.what);
  f.field("samples", e.samples);
  f.field("judging", e.judging);
  f.field("on", e.on);
  f.field("presses", e.presses);
  f.field("holds", e.holds);
  f.field("force_known", e.force_known);
  f.field("force_N", e.force_N);
  f.field("travel_m", e.travel_m);
  f.field("noise_N", e.noise_N);
  f.field("stiffness_N_m", e.stiffness_N_m);
  f.field("direction", e.direction);
  f.field("speed_m_s", e.speed_m_s);
  f.field("rate_N_s", e.rate_N_s);
  f.field("rest_N", e.rest_N);
  f.field("free_N", e.free_N);
  f.field("against_N", e.against_N);
  f.field("drift_N_s", e.drift_N_s);
  f.field("waver_N", e.waver_N);
  f.field("target_m", e.target_m);
  f.field("worst_N", e.worst_N);
  f.field("threshold_N", e.threshold_N);
  f.field("limit_N", e.limit_N);
  f.field("expected_N", e.expected_N);
  f.field("from_sample", e.from_sample);
  f.field("to_sample", e.to_sample);
  f.field("drift_error_N_s", e.drift_error_N_s);
  f.field("shift_N", e.shift_N);
  f.field("reason", e.reason);
}
template <class F>
void fields(F& f, RequestEvent& e) {
  f.field("pid", e.pid);
  f.field("request", e.request);
  f.field("uid", e.uid);
  f.field("user", e.user);
  f.field("why", e.why);
}

template <class F, EventKind kind>
void fields(F& f, AtAPlace<kind>& e) {
  f.field("place", e.place);
  f.field("step", e.step);
  f.field("steps_done", e.steps_done);
  f.field("why", e.why);
}
template <class F>
void fields(F& f, AnswerEvent& e) {
  f.field("question", e.question);
  f.field("type", e.type);
  f.field("number", e.number);
  f.field("unit", e.unit);
  f.field("text", e.text);
  f.field("source", e.source);
  f.field("by", e.by);
  f.field("repeat", e.repeat);
  f.field("from_run", e.from_run);
}

constexpr std::string_view kDone = "done";

}  // namespace

template <EventPayload P>
std::string to_json(const P& payload) {
  PayloadWriter writer;
  P copy = payload;
  fields(writer, copy);
  return writer.text();
}

template <EventPayload P>
Result<P> from_json(std::string_view detail) {
  const json object = json::parse(detail, nullptr, false);
  if (!object.is_object()) {
    return fail(Errc::garbled, "the event `{}` has no object in its detail", to_string(P::kKind));
  }
  PayloadReader reader(object);
  P out{};
  fields(reader, out);
  if (reader.missing() == nullptr) return out;
  return fail(Errc::garbled, "the event `{}` does not say `{}`", to_string(P::kKind),
              reader.missing());
}

template <>
std::string to_json(const StepEndEvent& e) {
  return e.stopped_by ? e.stopped_by->word() : std::string(kDone);
}

template <>
Result<StepEndEvent> from_json(std::string_view detail) {
  if (detail == kDone) return StepEndEvent();
  return StepEndEvent{EventName(std::string(detail))};
}

#define LCRIG_PAYLOAD(P)                          \
  template std::string to_json(const P& payload); \
  template Result<P> from_json(std::string_view detail);
LCRIG_PAYLOAD(MotionEvent)
LCRIG_PAYLOAD(WeightPlacedEvent)
LCRIG_PAYLOAD(ContactEvent)
LCRIG_PAYLOAD(NoContactEvent)
LCRIG_PAYLOAD(RestEvent)
LCRIG_PAYLOAD(DriftEvent)
LCRIG_PAYLOAD(OvershootEvent)
LCRIG_PAYLOAD(OvershootExceededEvent)
LCRIG_PAYLOAD(GapEvent)
LCRIG_PAYLOAD(ReconnectedEvent)
LCRIG_PAYLOAD(StiffnessEvent)
LCRIG_PAYLOAD(ZeroEvent)
LCRIG_PAYLOAD(GapStatedEvent)
LCRIG_PAYLOAD(ClockStepEvent)
LCRIG_PAYLOAD(LateSamplesEvent)
LCRIG_PAYLOAD(LevelAbandonedEvent)
LCRIG_PAYLOAD(ContinuesEvent)
LCRIG_PAYLOAD(SettingsEvent)
LCRIG_PAYLOAD(ReadBackEvent)
LCRIG_PAYLOAD(UnprovenEvent)
LCRIG_PAYLOAD(RunPoint)
LCRIG_PAYLOAD(WatchSetupEvent)
LCRIG_PAYLOAD(WatchInputEvent)
LCRIG_PAYLOAD(RequestEvent)
LCRIG_PAYLOAD(AnswerEvent)
LCRIG_PAYLOAD(StopAfterEvent)
LCRIG_PAYLOAD(PauseAtEvent)
#undef LCRIG_PAYLOAD

}  // namespace lcrig
