#include <ecorche/studio/app.h>
#include <ecorche/studio/main_window.h>
#include <ecorche/studio/theme.h>

#include <QApplication>
#include <QCommandLineParser>
#include <QScreen>
#include <QSettings>
#include <QSurfaceFormat>
#include <QTimer>

namespace ecorche::studio {

int run(int argc, char** argv) {
  QSurfaceFormat format;
  format.setVersion(3, 3);
  format.setProfile(QSurfaceFormat::CoreProfile);
  format.setDepthBufferSize(0);  // pictures bring their own
  QSurfaceFormat::setDefaultFormat(format);
  QApplication app(argc, argv);
  QApplication::setApplicationName("ecorche-studio");
  QApplication::setApplicationDisplayName(QObject::tr("Écorché"));
  QApplication::setOrganizationName("ecorche");
  QApplication::setApplicationVersion(ECORCHE_VERSION);

  QCommandLineParser parser;
  parser.setApplicationDescription(
      QObject::tr("Model muscles from skin, bones and curves.\n\nExamples:\n  ecorche-studio\n"
                  "  ecorche-studio forearm.ecorche\n  ecorche-studio skin.obj bones/*.obj"));
  parser.addHelpOption();
  parser.addVersionOption();
  const QCommandLineOption scale("scale", QObject::tr("Size of texts and buttons, 1 is usual"),
                                 "FACTOR");
  const QCommandLineOption tets("tets", QObject::tr("How many tets the view is made of"), "N");
  const QCommandLineOption shot(
      "screenshot", QObject::tr("Save a picture of the window once all is there, and quit"),
      "FILE");
  const QCommandLineOption choose("select", QObject::tr("Begin with this muscle selected"), "NAME");
  parser.addOption(shot);
  parser.addOption(choose);
  parser.addOption(scale);
  parser.addOption(tets);
  parser.addPositionalArgument("FILES", QObject::tr("A project, or meshes for a new one"),
                               "[FILES...]");
  parser.process(app);

  if (parser.isSet(scale)) {
    bool known = false;
    const double factor = parser.value(scale).toDouble(&known);
    if (!known || factor < 0.5 || factor > 4.0) {
      fprintf(stderr, "ecorche-studio: --scale takes a number from 0.5 to 4\n");
      return 2;
    }
    QFont font = QApplication::font();
    font.setPointSizeF(font.pointSizeF() * factor);
    QApplication::setFont(font);
  }
  engine::LiveOptions options;
  if (parser.isSet(tets)) {
    bool known = false;
    options.tets = parser.value(tets).toLongLong(&known);
    if (!known || options.tets < 1000) {
      fprintf(stderr, "ecorche-studio: --tets takes a number from 1000 up\n");
      return 2;
    }
  }
  options.refine = QSettings().value("refine", true).toBool();
  applyTheme(app, static_cast<Theme>(QSettings().value("theme", 0).toInt()));
  MainWindow window(options);
  // A terminal that the window was started from is told the same
  QObject::connect(&window.session(), &Session::told, [](Severity severity, const QString& text) {
    if (severity == Severity::Error) fprintf(stderr, "ecorche-studio: %s\n", qPrintable(text));
  });
  window.show();
  QTimer::singleShot(0, &window, [&] { window.openFiles(parser.positionalArguments()); });
  if (parser.isSet(choose)) {
    const std::string name = parser.value(choose).toStdString();
    QObject::connect(&window.session(), &Session::liveChanged, &window, [&window, name] {
      if (window.session().tissues()) window.session().select({name, -1, -1, {}});
    });
  }
  QTimer poll;
  if (parser.isSet(shot)) {
    // Twice quiet: what was asked for at the first may have asked for more
    QObject::connect(&poll, &QTimer::timeout, &window, [&, quiet = 0]() mutable {
      quiet = window.isQuiet() ? quiet + 1 : 0;
      if (quiet < 3) return;
      const QString file = parser.value(shot);
      const bool saved = window.screen()->grabWindow(window.winId()).save(file);
      if (!saved) fprintf(stderr, "ecorche-studio: %s cannot be written\n", qPrintable(file));
      QApplication::exit(saved ? 0 : 1);
    });
    poll.start(300);
  }
  return QApplication::exec();
}

}  // namespace ecorche::studio
