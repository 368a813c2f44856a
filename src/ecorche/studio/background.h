#pragma once

#include <ecorche/core/run_context.h>
#include <ecorche/studio/postbox.h>

#include <QObject>
#include <functional>
#include <memory>
#include <thread>

namespace ecorche::studio {

/// One piece of long work beside the window: progress and cancel, and a last word on the window's
/// thread.
class Background : public QObject {
  Q_OBJECT

 public:
  explicit Background(QObject* parent = nullptr) : QObject(parent) {}
  ~Background() override;  ///< cancels and waits

  /// @param work  runs beside the window; must not touch it
  /// @param done  runs on the window's thread afterwards, also after a cancel
  /// @pre not busy
  void start(std::function<void(RunContext&)> work, std::function<void()> done);
  void cancel();
  [[nodiscard]] bool isBusy() const { return run_ != nullptr; }

 signals:
  void progressed(const QString& stage, double fraction);

 private:
  std::shared_ptr<RunContext> run_;
  Postbox post_;
  std::thread thread_;
};

}  // namespace ecorche::studio
