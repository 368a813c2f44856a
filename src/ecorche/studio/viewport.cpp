#include <ecorche/render/views.h>
#include <ecorche/studio/spread_gizmo.h>
#include <ecorche/studio/viewport.h>

#include <QElapsedTimer>
#include <QMouseEvent>
#include <QOffscreenSurface>
#include <QOpenGLContext>
#include <QOpenGLFramebufferObject>
#include <QOpenGLFunctions>
#include <QPainter>
#include <QTabletEvent>
#include <QWheelEvent>
#include <algorithm>
#include <cmath>

namespace ecorche::studio {

using mesh::Vector3;

namespace {

constexpr int kRestMs = 180;  // without movement, before a picture is refined
constexpr int kFineSamples = 12;
constexpr double kSlow = 0.07;  // for a picture in motion [s]
constexpr int kMostDivisor = 3;

Eigen::Vector2d pixelOf(const QPointF& p) { return {p.x(), p.y()}; }

}  // namespace

QString Viewport::troubleOfMachine() {
  QOffscreenSurface surface;
  surface.setFormat(QSurfaceFormat::defaultFormat());
  surface.create();
  QOpenGLContext context;
  context.setFormat(QSurfaceFormat::defaultFormat());
  const bool made = context.create() && context.makeCurrent(&surface);
  const auto version = context.format().version();
  if (made) context.doneCurrent();
  if (made && version >= qMakePair(3, 3)) return {};
  return made
             ? tr("pictures need OpenGL 3.3 and this machine has %1.%2; a newer driver, or Mesa's "
                  "software renderer (LIBGL_ALWAYS_SOFTWARE=1), has it")
                   .arg(version.first)
                   .arg(version.second)
             : tr("pictures need OpenGL 3.3 and this machine has none; install a driver, or Mesa's "
                  "software renderer (libgl1-mesa-dri)");
}

Viewport::Viewport(Session& session, QWidget* parent) : QOpenGLWidget(parent), session_(session) {
  setObjectName("viewport");
  setMouseTracking(true);
  setFocusPolicy(Qt::StrongFocus);
  setMinimumSize(64, 64);
  setAccessibleName(tr("View of the model"));
  rest_.setSingleShot(true);
  rest_.setInterval(kRestMs);
  connect(&rest_, &QTimer::timeout, this, [this] {
    if (navigating_ || toolHolds_) return;
    sharp_ = true;
    quickPicture_ = !session_.display().fine;
    if (quickPicture_ && divisor_ == 1) return;
    dirty_ = true;
    update();
  });
  connect(&session_, &Session::projectChanged, this, &Viewport::redraw);
  connect(&session_, &Session::selectionChanged, this, &Viewport::redraw);
  connect(&session_, &Session::displayChanged, this, &Viewport::redraw);
  connect(&session_, &Session::fieldsChanged, this, &Viewport::redraw);
  connect(&session_, &Session::liveChanged, this, [this] {
    if (!session_.meshes()) framed_ = 0;
    frameWhenFirstSeen();
    redraw();
  });
}

Viewport::~Viewport() {
  if (!isValid()) return;
  makeCurrent();
  renderer_.reset();
  coarse_.reset();
  doneCurrent();
}

void Viewport::setTool(Tool* tool) {
  if (tool_ != nullptr) {
    tool_->cancel();
    tool_->disconnect(this);
  }
  tool_ = tool;
  toolHolds_ = false;
  if (tool_ != nullptr) {
    connect(tool_, &Tool::overlayChanged, this, [this] {
      setCursor(tool_->overlay().cursor);
      redraw();
    });
    setCursor(tool_->overlay().cursor);
  }
  redraw();
}

void Viewport::setColours(const SceneColours& colours) {
  colours_ = colours;
  redraw();
}

void Viewport::redraw() {
  dirty_ = true;
  quickPicture_ = true;
  sharp_ = false;
  finished_ = false;
  rest_.start();
  update();
}

mesh::Box Viewport::shownBox() const {
  if (session_.domain()) return mesh::boundingBox(session_.domain()->domain.mesh.V);
  const auto& meshes = session_.meshes();
  if (!meshes) return {Vector3::Constant(-0.5), Vector3::Constant(0.5)};
  return mesh::boundingBox(meshes->meshes.skin);
}

void Viewport::frameWhenFirstSeen() {
  // Once for the meshes, and once more for what cut planes leave of them, unless a hand was quicker
  const int wanted = session_.domain() ? 2 : session_.meshes() ? 1 : 0;
  if (framed_ >= wanted) return;
  framed_ = wanted;
  camera_.setAxes(render::guessedAxes(mesh::boundingBox(session_.meshes()->meshes.skin)));
  camera_.lookFrom(40.0, 12.0);
  camera_.frame(shownBox());
}

void Viewport::frameAll() {
  camera_.frame(shownBox());
  redraw();
}

void Viewport::frameSelected() {
  const model::Tissue* tissue = session_.selectedTissue();
  if (tissue == nullptr || tissue->curves.empty()) return frameAll();
  mesh::Box box{tissue->curves.front().points.front().at, tissue->curves.front().points.front().at};
  for (const model::Curve& curve : tissue->curves) {
    for (const auto& p : curve.points) {
      box.lo = box.lo.cwiseMin(p.at);
      box.hi = box.hi.cwiseMax(p.at);
    }
  }
  const Vector3 margin = Vector3::Constant(0.15 * (box.hi - box.lo).norm());
  camera_.frame({box.lo - margin, box.hi + margin});
  redraw();
}

void Viewport::lookFrom(double azimuthDeg, double elevationDeg) {
  camera_.lookFrom(azimuthDeg, elevationDeg);
  redraw();
}

void Viewport::setParallel(bool parallel) {
  camera_.setParallel(parallel);
  redraw();
}

void Viewport::flyTo(const Vector3& place) {
  const double size = session_.meshes() ? 0.1 * session_.meshes()->diagonal : 0.1;
  camera_.frame({place - Vector3::Constant(size), place + Vector3::Constant(size)});
  redraw();
}

void Viewport::initializeGL() {
  auto made = render::Renderer::create();
  if (!made) {
    trouble_ = QString::fromStdString(made.error().message);
    Q_EMIT troubled(trouble_);
    return;
  }
  renderer_.emplace(std::move(*made));
}

void Viewport::resizeGL(int, int) {
  camera_.resize(width(), height());
  redraw();
}

void Viewport::begin(bool quick) {
  SceneBuilder::Input input{session_.project(),
                            session_.meshes(),
                            session_.domain(),
                            session_.tissues(),
                            session_.takeFieldEdits(),
                            session_.display().fibers ? session_.flow() : nullptr,
                            session_.display(),
                            session_.selection(),
                            {},
                            {},
                            {},
                            {},
                            1.0 / divisorNow()};
  if (tool_ != nullptr) {
    input.hovered = tool_->overlay().hovered;
    input.stroke = tool_->overlay().stroke;
    input.marks = tool_->overlay().marks;
  }
  if (session_.display().spread) {
    if (const auto gizmo = SpreadGizmo::of(session_, camera_)) {
      input.guides = gizmo->axes();
      input.guides.push_back(gizmo->ring());
      const auto handles = gizmo->handles();
      input.marks.insert(input.marks.end(), handles.begin(), handles.end());
    }
  }
  render::PictureOptions how;
  how.width =
      std::max(1, static_cast<int>(std::lround(width() * devicePixelRatioF()) / divisorNow()));
  how.height =
      std::max(1, static_cast<int>(std::lround(height() * devicePixelRatioF()) / divisorNow()));
  how.gradient = true;
  if (quick) {
    how.motion = true;
  } else {
    how.samples = kFineSamples;
  }
  const render::Scene scene = scenes_.build(input, colours_);
  if (auto begun = renderer_->begin(scene, camera_.camera(), how); !begun) {
    trouble_ = QString::fromStdString(begun.error().message);
    Q_EMIT troubled(trouble_);
    renderer_.reset();
  }
}

void Viewport::paintGL() {
  QElapsedTimer clock;
  clock.start();
  if (renderer_ && dirty_) begin(quickPicture_);
  dirty_ = false;
  if (!renderer_) {
    QPainter painter(this);
    painter.fillRect(rect(), palette().window());
    painter.setPen(palette().windowText().color());
    painter.drawText(rect().adjusted(40, 40, -40, -40), Qt::AlignCenter | Qt::TextWordWrap,
                     tr("There is no picture: %1").arg(trouble_));
    return;
  }
  const bool more = renderer_->pass();
  if (divisorNow() > 1) {
    showCoarse();
  } else {
    QOpenGLFramebufferObject::bindDefault();
    renderer_->resolve(0, 0);
  }
  if (quickPicture_ && !sharp_) {
    context()->functions()->glFinish();
    adaptDivisor(1e-9 * static_cast<double>(clock.nsecsElapsed()));
  }
  Q_EMIT drawn();
  if (quickPicture_) {
    finished_ = !session_.display().fine && (sharp_ || divisor_ == 1);
  } else if (more) {
    QTimer::singleShot(0, this, [this] { update(); });
  } else {
    finished_ = true;
  }
}

// The picture drawn with fewer pixels than the window has, spread over it.
void Viewport::showCoarse() {
  const QSize whole(static_cast<int>(std::lround(width() * devicePixelRatioF())),
                    static_cast<int>(std::lround(height() * devicePixelRatioF())));
  const QSize few(std::max(1, whole.width() / divisor_), std::max(1, whole.height() / divisor_));
  if (!coarse_ || coarse_->size() != few) coarse_ = std::make_unique<QOpenGLFramebufferObject>(few);
  coarse_->bind();
  renderer_->resolve(0, 0);
  QOpenGLFramebufferObject::blitFramebuffer(nullptr, QRect(QPoint(0, 0), whole), coarse_.get(),
                                            QRect(QPoint(0, 0), few), GL_COLOR_BUFFER_BIT,
                                            GL_LINEAR);
  QOpenGLFramebufferObject::bindDefault();
}

// A machine without a graphics card fills pixels slowly: in motion the hand is better served by
// half of them at once than by all of them late.
void Viewport::adaptDivisor(double seconds) {
  if (seconds > kSlow && divisor_ < kMostDivisor) {
    ++divisor_;
  } else if (divisor_ > 1) {
    const double finer = static_cast<double>(divisor_) / (divisor_ - 1);
    if (seconds * finer * finer < 0.6 * kSlow) --divisor_;
  }
}

Touch Viewport::touchOf(const QMouseEvent& event) {
  return {pixelOf(event.position()), event.modifiers(), std::nullopt};
}

void Viewport::navigate(const Eigen::Vector2d& pixel) {
  framed_ = 2;
  const Eigen::Vector2d by = pixel - last_;
  switch (*navigating_) {
    case NavigationAct::Turn:
      camera_.orbit(by.x(), by.y());
      break;
    case NavigationAct::Pan:
      camera_.pan(by.x(), by.y());
      break;
    case NavigationAct::Zoom:
      camera_.dolly(-0.02 * by.y(), {0.5 * width(), 0.5 * height()});
      break;
  }
  redraw();
}

void Viewport::pressed(Qt::MouseButton button, const Touch& touch) {
  last_ = touch.pixel;
  if (!renderer_ && trouble_.isEmpty()) return;
  // A tool is asked first, unless the preset takes the button whatever lies under it
  navigating_ = navigationAct(navigation_, button, touch.modifiers, true);
  if (!navigating_ && button == Qt::LeftButton)
    toolHolds_ = tool_ != nullptr && session_.isOpen() && tool_->press(touch);
  if (!navigating_ && !toolHolds_)
    navigating_ = navigationAct(navigation_, button, touch.modifiers, false);
  if (navigating_) setCursor(Qt::SizeAllCursor);
}

void Viewport::moved(const Touch& touch, bool down) {
  if (navigating_) {
    navigate(touch.pixel);
  } else if (toolHolds_ && down) {
    tool_->drag(touch);
    redraw();
  } else if (tool_ != nullptr && session_.isOpen()) {
    tool_->hover(touch);
  }
  last_ = touch.pixel;
}

void Viewport::released(const Touch& touch) {
  if (toolHolds_) tool_->release(touch);
  toolHolds_ = false;
  navigating_.reset();
  setCursor(tool_ != nullptr ? tool_->overlay().cursor : Qt::ArrowCursor);
  redraw();
}

void Viewport::mousePressEvent(QMouseEvent* event) { pressed(event->button(), touchOf(*event)); }
void Viewport::mouseMoveEvent(QMouseEvent* event) {
  moved(touchOf(*event), event->buttons() != Qt::NoButton);
}
void Viewport::mouseReleaseEvent(QMouseEvent* event) { released(touchOf(*event)); }
void Viewport::mouseDoubleClickEvent(QMouseEvent* event) {
  if (event->button() == Qt::LeftButton && tool_ != nullptr && session_.isOpen())
    tool_->doubleClick(touchOf(*event));
}

void Viewport::tabletEvent(QTabletEvent* event) {
  const Touch touch{pixelOf(event->position()), event->modifiers(), event->pressure()};
  if (event->type() == QEvent::TabletPress) {
    pressed(event->button(), touch);
  } else if (event->type() == QEvent::TabletMove) {
    moved(touch, event->buttons() != Qt::NoButton);
  } else if (event->type() == QEvent::TabletRelease) {
    released(touch);
  }
  event->accept();
}

void Viewport::wheelEvent(QWheelEvent* event) {
  // Alt turns a vertical wheel into a horizontal one
  const double steps = (event->angleDelta().y() + event->angleDelta().x()) / 120.0;
  const Selection& s = session_.selection();
  if (event->modifiers().testFlag(Qt::AltModifier) && s.point >= 0) {
    const model::Tissue* tissue = session_.selectedTissue();
    const auto curve = static_cast<std::size_t>(s.curve);
    const auto point = static_cast<std::size_t>(s.point);
    session_.perform(
        model::SetPointValue{s.tissue, curve, point,
                             tissue->curves[curve].points[point].tissue * std::pow(1.1, steps)},
        tr("Tissue value of %1").arg(QString::fromStdString(s.tissue)));
  } else {
    camera_.dolly(steps, pixelOf(event->position()));
    redraw();
  }
  event->accept();
}

void Viewport::leaveEvent(QEvent*) {
  if (tool_ != nullptr && !toolHolds_ && session_.isOpen())
    tool_->hover({{-1e4, -1e4}, Qt::NoModifier, std::nullopt});
}

}  // namespace ecorche::studio
