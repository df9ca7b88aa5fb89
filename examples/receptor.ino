// A receptor for Armspan: a phototransistor at A0 of any Arduino. Never compiled; adjust the thresholds to your light.
const int EYE = A0; bool lit = false; unsigned long said = 0;
void setup() { Serial.begin(115200); }
void loop() {
  bool now = analogRead(EYE) > (lit ? 500 : 600);           // two thresholds: no chatter at the rim
  if (now != lit || (now && millis() - said > 200)) {
    lit = now; said = millis();
    Serial.println(lit ? "hit amber" : "lost amber");
  }
}
