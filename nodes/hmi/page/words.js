// The page's texts: which language, a text with its values, and putting texts into the document.
import en from "./words/en.js";
import fr from "./words/fr.js";

const LANGUAGES = { en, fr };
const KEPT = "language";
let language = "en";

/** Return the text of a key with its {placeholders} replaced; the key itself if there is none. */
export function word(key, values = {}) {
  const text = LANGUAGES[language][key] ?? key;
  return text.replace(/\{(\w+)\}/g, (whole, name) => values[name] ?? whole);
}

/** Return a number with so many decimals, as the language writes it. */
export function number(value, decimals = 0) {
  return value.toLocaleString(language, {
    minimumFractionDigits: decimals,
    maximumFractionDigits: decimals,
  });
}

/** Choose the language: what the person chose before, else the browser's, else the server's. */
export function firstLanguage(servers) {
  const wanted = [stored(), ...navigator.languages.map((tag) => tag.slice(0, 2)), servers, "en"];
  return wanted.find((tag) => tag in LANGUAGES);
}

/** Use a language from now on, in the whole document; `keep` if the person chose it. */
export function speak(wanted, keep = false) {
  language = wanted in LANGUAGES ? wanted : "en";
  if (keep) store(language);
  document.documentElement.lang = language;
  for (const element of document.querySelectorAll("[data-word]")) {
    element.textContent = word(element.dataset.word);
  }
  for (const element of document.querySelectorAll("[data-label]")) {
    element.setAttribute("aria-label", word(element.dataset.label));
  }
  document.dispatchEvent(new Event("language"));
}

/** Connect the list of languages; `servers` is the deployment's language. */
export function offerLanguages(select, servers) {
  speak(firstLanguage(servers));
  select.value = language;
  select.onchange = () => speak(select.value, true);
}

function stored() {
  try {
    return localStorage.getItem(KEPT) ?? "";
  } catch {
    return ""; // a browser that keeps nothing
  }
}

function store(value) {
  try {
    localStorage.setItem(KEPT, value);
  } catch {
    // then it is chosen again next time
  }
}
